//! Taxels on the hands of a world.

use crate::error;
use crate::numbers::rows;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::Mutex;
use thenar_core::readout::{TaxelContact, TaxelReadout};
use thenar_core::{Vec3, World};
use thenar_scene::build::BuiltHand;
use thenar_scene::session::Session;
use thenar_scene::taxels::{Layout, TaxelPatch, layout, on_bone};

/// Most taxels on one hand: more than any skin that is built, and few enough to be read in each
/// step.
const TAXELS_MAX: usize = 100_000;

/// Taxels of one hand, in patches.
#[pyclass(frozen, module = "thenar._thenar")]
#[derive(Debug)]
pub struct Taxels {
    readout: Mutex<TaxelReadout>,
    patches: Vec<(String, usize, usize)>,
    /// Collision vertices of the body that they are on: of another world they would read nonsense.
    vertices: usize,
    soft: u32,
}

fn hand(session: &Session, hand: usize) -> PyResult<(&BuiltHand, u32)> {
    let no_skin = || PyValueError::new_err(format!("there is no hand {hand} with skin"));
    let built = session.hands().get(hand).ok_or_else(no_skin)?;
    Ok((built, built.flesh().ok_or_else(no_skin)?))
}

impl Taxels {
    /// Taxels of a shipped layout.
    ///
    /// # Errors
    /// There is no such layout, or it has too many taxels.
    pub fn of_layout(
        session: &Session,
        of: usize,
        name: &str,
        [rows, columns]: [usize; 2],
        reach: f64,
    ) -> PyResult<Self> {
        let (hand, soft) = hand(session, of)?;
        let which = Layout::named(name).ok_or_else(|| {
            let known = Layout::NAMES.join(", ");
            PyValueError::new_err(format!("there is no layout `{name}`: there are {known}"))
        })?;
        check_count(rows.saturating_mul(columns))?;
        let patches = layout(&hand.model, which, rows, columns);
        check_count(patches.len() * rows * columns)?;
        Self::new(session.world(), soft, &patches, reach)
    }

    /// Taxels where bones' skin is nearest to points.
    ///
    /// # Errors
    /// There is no such bone, a number is not finite, or there are too many.
    pub fn at_points(
        session: &Session,
        of: usize,
        points: &[(String, Vec<u8>)],
        reach: f64,
    ) -> PyResult<Self> {
        let (hand, soft) = hand(session, of)?;
        check_count(points.iter().map(|(_, bytes)| bytes.len() / 24).sum())?;
        let patch = |(bone, bytes): &(String, Vec<u8>)| {
            let points: Vec<Vec3> = rows::<3>(bytes)?.into_iter().map(Vec3::from).collect();
            if !points.iter().all(|point| point.iter().all(|x| x.is_finite())) {
                return Err(PyValueError::new_err(format!("a point of {bone} is not finite")));
            }
            on_bone(&hand.model, bone, &points).ok_or_else(|| {
                PyValueError::new_err(format!(
                    "hand `{}` has no skin on a bone `{bone}`",
                    hand.name
                ))
            })
        };
        let patches = points.iter().map(patch).collect::<PyResult<Vec<_>>>()?;
        Self::new(session.world(), soft, &patches, reach)
    }

    fn new(world: &World, soft: u32, patches: &[TaxelPatch], reach: f64) -> PyResult<Self> {
        if reach.is_nan() || reach < 0.0 {
            return Err(PyValueError::new_err(format!("reach: expected 0 or more, got {reach}")));
        }
        let places: Vec<_> = patches.iter().flat_map(|patch| patch.places.clone()).collect();
        let readout = TaxelReadout::new(world, soft, &places, reach)
            .map_err(|e| PyValueError::new_err(e.to_string()))?;
        let row = |patch: &TaxelPatch| (patch.name.clone(), patch.rows, patch.columns);
        Ok(Self {
            readout: Mutex::new(readout),
            patches: patches.iter().map(row).collect(),
            vertices: world.collision_vertices(soft).len(),
            soft,
        })
    }

    /// Readings of the taxels, 22 numbers each; then a row more, whose first three are the force
    /// that none feels.
    ///
    /// # Errors
    /// The taxels are another world's.
    pub fn read<'py>(&self, py: Python<'py>, world: &World) -> PyResult<Bound<'py, PyBytes>> {
        let softs = world.desc().softs.len();
        let fits = (self.soft as usize) < softs
            && world.collision_vertices(self.soft).len() == self.vertices;
        if !fits {
            return Err(PyValueError::new_err("the taxels are another world's"));
        }
        let mut readout = self.readout.lock().map_err(|_| error::broken())?;
        readout.read(world);
        let mut numbers: Vec<f64> = Vec::with_capacity(22 * (readout.taxels().len() + 1));
        readout.taxels().iter().for_each(|taxel| append(&mut numbers, taxel));
        let missed = TaxelContact { force_W: readout.missed_W(), ..TaxelContact::default() };
        append(&mut numbers, &missed);
        Ok(PyBytes::new(py, bytemuck::cast_slice(&numbers)))
    }
}

fn check_count(count: usize) -> PyResult<()> {
    match count {
        0..=TAXELS_MAX => Ok(()),
        _ => Err(PyValueError::new_err(format!("{count} taxels: expected at most {TAXELS_MAX}"))),
    }
}

fn append(numbers: &mut Vec<f64>, taxel: &TaxelContact) {
    numbers.extend(taxel.force_W.iter());
    numbers.push(taxel.normal);
    numbers.extend(taxel.shear);
    numbers.extend([taxel.area, taxel.pressure]);
    numbers.extend(taxel.slip);
    numbers.extend(taxel.position_W.iter());
    taxel.axes_W.iter().for_each(|axis| numbers.extend(axis.iter()));
}

#[pymethods]
impl Taxels {
    /// Name, rows and columns of each patch.
    fn patches(&self) -> Vec<(String, usize, usize)> {
        self.patches.clone()
    }
}
