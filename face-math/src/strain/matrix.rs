//! Products of large matrices, cut into fixed pieces: the same bits whatever the number of threads.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::*;

/// Columns of a product that are computed together: whole vertices of three.
const PIECE: usize = 192;

/// `left` · `right`, piece by piece over the columns.
pub(super) fn product(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    let (rows, columns) = (left.nrows(), right.ncols());
    let mut out = Mat::<f64>::zeros(rows, columns);
    pieces(out.as_mut(), |first, mut out| {
        let right = right.subcols(first, out.ncols());
        matmul(out.as_mut(), Accum::Replace, left, right, 1.0, Par::Seq);
    });
    out
}

/// Calls `each` with fixed pieces of the columns of `out`, in parallel, and the first column of each.
pub(super) fn pieces(out: MatMut<'_, f64>, each: impl Fn(usize, MatMut<'_, f64>) + Sync) {
    let columns = out.ncols();
    let mut rest = out;
    let mut cut = Vec::new();
    let mut first = 0;
    while first < columns {
        let width = PIECE.min(columns - first);
        let (own, others) = rest.split_at_col_mut(width);
        cut.push((first, own));
        rest = others;
        first += width;
    }
    cut.into_par_iter().for_each(|(first, out)| each(first, out));
}

/// `a` · `aᵀ` over the columns of `a`, summed in fixed runs of columns in their order.
pub(super) fn outer(a: MatRef<'_, f64>) -> Mat<f64> {
    let size = a.nrows();
    let run = 4096;
    let runs: Vec<usize> = (0..a.ncols()).step_by(run).collect();
    let parts: Vec<Mat<f64>> = runs
        .into_par_iter()
        .map(|first| {
            let own = a.subcols(first, run.min(a.ncols() - first));
            let mut part = Mat::<f64>::zeros(size, size);
            matmul(part.as_mut(), Accum::Replace, own, own.transpose(), 1.0, Par::Seq);
            part
        })
        .collect();
    parts.into_iter().fold(Mat::zeros(size, size), |sum, part| sum + part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_make_the_whole_product() {
        let a = Mat::from_fn(5, 700, |i, j| ((i * 31 + j * 17) % 23) as f64 - 11.0);
        let b = Mat::from_fn(700, 451, |i, j| ((i * 7 + j * 13) % 29) as f64 - 14.0);
        assert_eq!(product(a.as_ref(), b.as_ref()), &a * &b);
        let wide = Mat::from_fn(4, 9000, |i, j| ((i * 5 + j) % 7) as f64);
        assert_eq!(outer(wide.as_ref()), &wide * wide.transpose());
    }
}
