//! `W = B G Bᵀ`, one batch of its columns at a time.

use super::handles::Handles;
use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::factor::{LANES, Lanes, Scalar};
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x16};

/// Work space of the product.
#[derive(Clone, Debug)]
pub struct CombineWorkspace {
    /// One batch of columns of `G Bᵀ`: per handle, one register.
    answers: Aligned<Scalar>,
}

impl CombineWorkspace {
    /// Room for `batches` batches of handles.
    pub fn new(batches: usize) -> Self {
        Self { answers: Aligned::new(batches * LANES * LANES) }
    }

    /// Fills W, of the first `members`, but for what those before `done` have among themselves.
    #[inline(always)]
    pub fn fill<S: Simd>(
        &mut self,
        simd: S,
        G: &Compliance,
        handles: &Handles,
        (done, members): (usize, usize),
        W: &mut Compliance,
    ) {
        let used = handles.list().len().next_multiple_of(LANES);
        for batch in 3 * done / LANES..(3 * members).div_ceil(LANES) {
            let answers = &mut self.answers.as_chunks_mut::<LANES>().0[..used];
            let first = batch * LANES;
            let end = members.min((first + LANES).div_ceil(3));
            if let Some(column) = own_columns(handles, first, end) {
                for (k, answers) in answers.iter_mut().enumerate() {
                    answers.copy_from_slice(G.window(k, column));
                }
            } else {
                answers.fill([0.0; LANES]);
                for m in first / 3..end {
                    answer(simd, G, handles, m, first, answers);
                }
            }
            // Down to the diagonal; the rest by symmetry.
            for m in 0..end {
                if let Some(column) = handles.own_column(m) {
                    for a in 0..3 {
                        W.lanes_mut(3 * m + a, batch).copy_from_slice(&answers[column + a]);
                    }
                    continue;
                }
                let mut rows = [f32x16::splat(simd, 0.0); 3];
                for term in handles.terms(m) {
                    let answer = f32x16::from_slice(simd, &answers[term.column as usize]);
                    for a in 0..3 {
                        rows[a] = answer.mul_add(f32x16::splat(simd, term.weights[a]), rows[a]);
                    }
                }
                for a in 0..3 {
                    rows[a].store_slice(W.lanes_mut(3 * m + a, batch));
                }
            }
            W.mirror(batch);
        }
    }
}

/// Returns the first column of G for the columns of W from `first` on, up to those of member `end`,
/// if these fill a batch and all lie side by side in G.
fn own_columns(handles: &Handles, first: usize, end: usize) -> Option<usize> {
    let start = handles.own_column(first / 3)?;
    let full = 3 * end >= first + LANES;
    let follows = |m: usize| handles.own_column(m) == Some(start + 3 * (m - first / 3));
    (full && (first / 3..end).all(follows)).then_some(start + first % 3)
}

/// Adds up the response of the handles to impulses of member m, in the lanes of its columns, the
/// first of the batch being `first`.
#[inline(always)]
fn answer<S: Simd>(
    simd: S,
    G: &Compliance,
    handles: &Handles,
    m: usize,
    first: usize,
    answers: &mut [Lanes],
) {
    for (batch, answers) in answers.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
        let mut columns = [f32x16::splat(simd, 0.0); 3];
        for term in handles.terms(m) {
            let g = f32x16::from_slice(simd, G.lanes(term.column as usize, batch));
            for a in 0..3 {
                columns[a] = g.mul_add(f32x16::splat(simd, term.weights[a]), columns[a]);
            }
        }
        for a in 0..3 {
            let Some(lane) = (3 * m + a).checked_sub(first).filter(|lane| *lane < LANES) else {
                continue;
            };
            let column = columns[a].as_slice();
            for k in 0..LANES {
                answers[k][lane] = column[k];
            }
        }
    }
}
