//! Bodies made of meshes. To prepare a mesh is most of the work of opening a scene that has one:
//! bodies that were prepared before in this process are taken from there.

use super::recent::Recent;
use thenar_core::shape::Shape;
use thenar_rig::mesh::GridOptions;
use thenar_rig::object::{
    Car, ImportOptions, RigidModel, SoftModel, Weight, rigid_from_mesh, toy_car,
};
use thenar_rig::{RigError, TriMesh};

/// Room for what is kept of each kind \[bytes\]: a dozen meshes with the largest usual grid, a
/// million values of four bytes. A mesh of more than some hundred thousand triangles is not kept.
const ROOM: usize = 64 << 20;
/// A triangle in the mesh itself, in what touches, in its index and in what is drawn; or a
/// tetrahedron: about \[bytes\].
const ELEMENT: usize = 500;

/// Meshes with the cells of their grids. They weigh as much as their volume, at density 1.
static RIGIDS: Recent<(TriMesh, u32), RigidModel> = Recent::new(ROOM);
/// Toy cars by all that sets them apart, written out.
static CARS: Recent<String, (RigidModel, f64)> = Recent::new(ROOM);
/// Meshes with their wanted numbers of tetrahedra.
static SOFTS: Recent<(TriMesh, u32), SoftModel> = Recent::new(ROOM);

/// [`rigid_from_mesh`], or what that gave for the same mesh and grid before, whatever it weighed.
///
/// # Errors
/// As there.
pub fn rigid_of(mesh: TriMesh, cells: u32, weight: Weight) -> Result<RigidModel, RigError> {
    weight.mass(1.0)?;
    let grid = GridOptions { cells, ..GridOptions::default() };
    let options = ImportOptions { grid, ..ImportOptions::default() };
    let make = |(mesh, _): &(TriMesh, u32)| {
        rigid_from_mesh("mesh", mesh, Weight::Density(1.0), &options).map(|(model, _)| model)
    };
    let model = RIGIDS.get_or_make((mesh, cells), make, rigid_size)?;
    let mass = weight.mass(model.mass)?;
    Ok(RigidModel { mass, inertia: model.inertia * (mass / model.mass), ..model })
}

/// [`toy_car`] and its volume \[m³\], or what that gave before.
///
/// # Errors
/// As there.
pub fn car_of(car: &Car) -> Result<(RigidModel, f64), RigError> {
    let make = |_: &String| toy_car(car).map(|(model, report)| (model, report.volume));
    CARS.get_or_make(format!("{car:?}"), make, |(model, _)| rigid_size(model))
}

/// Returns the soft body of `make`, or that of the same mesh and number of tetrahedra before.
///
/// # Errors
/// Those of `make`.
pub fn soft_of<E>(
    mesh: TriMesh,
    tets: u32,
    make: impl FnOnce(&TriMesh) -> Result<SoftModel, E>,
) -> Result<SoftModel, E> {
    let make = |(mesh, _): &(TriMesh, u32)| make(mesh);
    SOFTS.get_or_make((mesh, tets), make, |model| {
        let surfaces = [&model.flesh.collision, &model.render].map(|s| s.triangles.len());
        ELEMENT * (model.flesh.tets.len() + surfaces.iter().sum::<usize>())
    })
}

fn rigid_size(model: &RigidModel) -> usize {
    let Shape::Mesh(shape) = &model.shape else { return 0 };
    let triangles = model.render.triangles.len().max(shape.triangles.len());
    4 * shape.grid.values.len() + ELEMENT * triangles.max(model.render.positions.len() / 4)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use thenar_core::Vec3;
    use thenar_rig::mesh::shapes;

    fn shape(model: &RigidModel) -> &Arc<thenar_core::shape::MeshShape> {
        match &model.shape {
            Shape::Mesh(shape) => shape,
            _ => panic!("a mesh"),
        }
    }

    /// One grid for a mesh of any weight, and the masses and inertias of bodies that are made
    /// afresh, to the bit.
    #[test]
    fn a_mesh_is_prepared_once_for_all_weights() {
        let mesh = || shapes::cuboid(&Vec3::new(0.011, 0.022, 0.033));
        let first = rigid_of(mesh(), 20, Weight::Mass(0.3)).unwrap();
        for weight in [Weight::Density(700.0), Weight::Mass(0.05), Weight::Mass(0.3)] {
            let again = rigid_of(mesh(), 20, weight).unwrap();
            assert!(Arc::ptr_eq(shape(&first), shape(&again)));
            let grid = GridOptions { cells: 20, ..GridOptions::default() };
            let options = ImportOptions { grid, ..ImportOptions::default() };
            let fresh = rigid_from_mesh("mesh", &mesh(), weight, &options).unwrap().0;
            assert_eq!((again.mass, again.inertia), (fresh.mass, fresh.inertia));
            assert_eq!((again.pose_MB, &again.render), (fresh.pose_MB, &fresh.render));
            assert_eq!(shape(&fresh).grid.values, shape(&first).grid.values);
        }
        let finer = rigid_of(mesh(), 24, Weight::Mass(0.3)).unwrap();
        assert!(shape(&finer).grid.values.len() > shape(&first).grid.values.len());
        let other = shapes::cuboid(&Vec3::new(0.011, 0.022, 0.034));
        let other = rigid_of(other, 20, Weight::Mass(0.3)).unwrap();
        assert!(!Arc::ptr_eq(shape(&first), shape(&other)));
        for weight in [Weight::Mass(-1.0), Weight::Density(f64::NAN)] {
            assert!(rigid_of(mesh(), 20, weight).is_err(), "{weight:?}");
        }
    }

    #[test]
    fn a_car_is_made_once() {
        let car = Car { length: 0.07, mass: 0.1 };
        let [(first, volume), (again, _)] = [(), ()].map(|()| car_of(&car).unwrap());
        assert!(Arc::ptr_eq(shape(&first), shape(&again)) && volume > 0.0);
        let (heavy, _) = car_of(&Car { mass: 0.2, ..car }).unwrap();
        assert!((heavy.mass - 0.2).abs() < 1e-15 && (first.mass - 0.1).abs() < 1e-15);
    }
}
