//! faer's sparse Cholesky factor, simplicial or by supernodes as it chooses.

use crate::Engine;
use crate::flesh::Matrix;
use crate::math::Vec3;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltParams;
use faer::perm::Perm;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::traits::RealField;
use faer::{Auto, Conj, Mat, Par, Side, Spec};

/// Columns that are solved together.
const COLUMNS: usize = 16;

pub struct Faer<T: RealField> {
    name: String,
    matrix: SparseColMat<usize, T>,
    symbolic: SymbolicCholesky<usize>,
    values: Vec<T>,
    stack: MemBuffer,
    column: Mat<T>,
    columns: Mat<T>,
    pub par: Par,
    convert: fn(f64) -> T,
    back: fn(&T) -> f64,
}

impl<T: RealField> Faer<T> {
    /// By minimum degree, or in the order given.
    pub fn new(
        (name, convert, back): (&str, fn(f64) -> T, fn(&T) -> f64),
        matrix: &Matrix,
        order: Option<&[usize]>,
        threshold: SupernodalThreshold,
    ) -> Self {
        let n = matrix.size();
        let (starts, rows, values) = matrix.upper();
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        let matrix = SparseColMat::new(pattern, values.into_iter().map(convert).collect());
        let order = order.map(|order| {
            let mut inverse = vec![0; n];
            order.iter().enumerate().for_each(|(place, &i)| inverse[i] = place);
            Perm::new_checked(order.into(), inverse.into(), n)
        });
        let ordering = match &order {
            Some(perm) => SymmetricOrdering::Custom(perm.as_ref()),
            None => SymmetricOrdering::Amd,
        };
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: threshold,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(matrix.symbolic(), Side::Upper, ordering, params)
                .expect("memory for the structure");
        // Room for two threads too.
        let par = Par::rayon(2);
        let scratch = symbolic
            .factorize_numeric_llt_scratch::<T>(par, spec::<T>())
            .or(symbolic.solve_in_place_scratch::<T>(COLUMNS, par));
        let kind = match symbolic.raw() {
            SymbolicCholeskyRaw::Simplicial(_) => "simplicial",
            SymbolicCholeskyRaw::Supernodal(_) => "supernodes",
        };
        let by = if order.is_some() { "our order" } else { "its order" };
        let zero = || convert(0.0);
        Self {
            name: format!("faer, {name}, {kind}, {by}"),
            values: (0..symbolic.len_val()).map(|_| zero()).collect(),
            stack: MemBuffer::new(scratch),
            column: Mat::from_fn(n, 1, |_, _| zero()),
            columns: Mat::from_fn(n, COLUMNS, |_, _| zero()),
            par: Par::Seq,
            matrix,
            symbolic,
            convert,
            back,
        }
    }
}

fn spec<T: RealField>() -> Spec<LltParams, T> {
    <LltParams as Auto<T>>::auto().into()
}

impl<T: RealField> Engine for Faer<T> {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn numbers(&self) -> usize {
        self.symbolic.len_val()
    }

    fn refresh(&mut self) -> bool {
        let factored = self.symbolic.factorize_numeric_llt(
            &mut self.values,
            self.matrix.as_ref(),
            Side::Upper,
            Default::default(),
            self.par,
            MemStack::new(&mut self.stack),
            spec::<T>(),
        );
        factored.is_ok()
    }

    fn solve(&mut self, x: &mut [Vec3]) {
        for (i, x) in x.iter().enumerate() {
            (0..3).for_each(|k| self.column[(3 * i + k, 0)] = (self.convert)(x[k]));
        }
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            self.column.as_mut(),
            self.par,
            MemStack::new(&mut self.stack),
        );
        for (i, x) in x.iter_mut().enumerate() {
            (0..3).for_each(|k| x[k] = (self.back)(&self.column[(3 * i + k, 0)]));
        }
    }

    fn solve_columns(&mut self, touched: Option<usize>) {
        for j in 0..COLUMNS {
            for i in 0..self.columns.nrows() {
                let there = touched.is_none_or(|node| i == 3 * node + j && j < 3);
                self.columns[(i, j)] = (self.convert)(f64::from(u8::from(there)));
            }
        }
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            self.columns.as_mut(),
            self.par,
            MemStack::new(&mut self.stack),
        );
    }

    fn two_threads_agree(&mut self) -> Option<bool> {
        self.refresh();
        let bits =
            |values: &[T]| values.iter().map(|x| (self.back)(x).to_bits()).collect::<Vec<_>>();
        let alone = bits(&self.values);
        self.par = Par::rayon(2);
        let agree = (0..20).all(|_| {
            self.refresh();
            alone == self.values.iter().map(|x| (self.back)(x).to_bits()).collect::<Vec<_>>()
        });
        self.par = Par::Seq;
        Some(agree)
    }
}
