//! Checks of skin.

use super::{count, index, not_negative, number};
use crate::model::{Sheet, Skin, SoftDesc, WorldDesc};
use crate::world::ModelError;

/// Returns the first fault found.
pub fn check(skin: &Skin, desc: &WorldDesc) -> Result<(), ModelError> {
    index("skin", "deformable body", u64::from(skin.soft), desc.softs.len())?;
    let SoftDesc { name, flesh, .. } = &desc.softs[skin.soft as usize];
    let skins = desc.skins.iter().filter(|other| other.soft == skin.soft).count();
    count(name, "list of skins", 1, skins)?;
    skin.sheets.iter().try_for_each(|sheet| check_sheet(name, sheet))?;
    for facet in &skin.facets {
        index(name, "tetrahedron of skin", u64::from(facet.tet), flesh.tets.len())?;
        index(name, "kind of skin", u64::from(facet.sheet), skin.sheets.len())?;
        number(name, "area of skin", "positive [m²]", facet.area, |x| x > 0.0 && x.is_finite())?;
        number(name, "length of a normal of skin", "1", facet.normal.norm(), |x| {
            (x - 1.0).abs() < 1e-6
        })?;
    }
    Ok(())
}

fn check_sheet(name: &str, sheet: &Sheet) -> Result<(), ModelError> {
    let finite = |x: f64| x > 0.0 && x < 1e13;
    number(name, "thickness of skin", "positive [m]", sheet.thickness, finite)?;
    number(name, "Young's modulus of skin", "positive [Pa]", sheet.young, finite)?;
    number(name, "Poisson's ratio of skin", "above -1 and below 0.5", sheet.poisson, |x| {
        x > -1.0 && x < 0.5
    })?;
    not_negative(name, "pretension of skin [N/m]", sheet.pretension)?;
    not_negative(name, "wrinkling strain of skin", sheet.wrinkling)
}
