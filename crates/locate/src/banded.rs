//! What solves a chain of unknowns, each tied to the next, and how sure is each? In time that grows with its length.
//!
//! Normal equations of a chain: 4×4 blocks on the diagonal and beside it ──block Cholesky──▶ solution, covariances of each link
//!
//! Source: Golub & Van Loan, §4.5 (block tridiagonal systems); Takahashi, Fagan & Chin 1973 (the inverse's diagonal only), which
//! on a chain is the smoother of Rauch, Tung & Striebel.

use nalgebra::{Matrix4, Vector4};

/// Symmetric, block tridiagonal, with a right-hand side.
#[derive(Debug, Clone)]
pub(crate) struct Chain {
    pub diagonal: Vec<Matrix4<f64>>,
    /// Row i, column i + 1.
    pub beside: Vec<Matrix4<f64>>,
    pub right: Vec<Vector4<f64>>,
}

impl Chain {
    pub(crate) fn zeros(links: usize) -> Self {
        Self {
            diagonal: vec![Matrix4::zeros(); links],
            beside: vec![Matrix4::zeros(); links.saturating_sub(1)],
            right: vec![Vector4::zeros(); links],
        }
    }

    /// Inverses of the eliminated diagonal blocks, each damped by `damping` times its own diagonal; `None` when not positive.
    fn eliminated(&self, damping: f64) -> Option<Vec<Matrix4<f64>>> {
        let mut inverses: Vec<Matrix4<f64>> = Vec::with_capacity(self.diagonal.len());
        for (i, diagonal) in self.diagonal.iter().enumerate() {
            let mut block = diagonal + Matrix4::from_diagonal(&(diagonal.diagonal() * damping));
            if i > 0 {
                let beside = &self.beside[i - 1];
                block -= beside.transpose() * inverses[i - 1] * beside;
            }
            inverses.push(block.cholesky()?.inverse());
        }
        Some(inverses)
    }

    /// The solution of (A + damping · diag A) x = right; `None` when that is not positive definite.
    pub(crate) fn solve(&self, damping: f64) -> Option<Vec<Vector4<f64>>> {
        let inverses = self.eliminated(damping)?;
        let mut x = self.right.clone();
        for i in 1..x.len() {
            let carried = self.beside[i - 1].transpose() * (inverses[i - 1] * x[i - 1]);
            x[i] -= carried;
        }
        for i in (0..x.len()).rev() {
            let later = x.get(i + 1).map_or_else(Vector4::zeros, |next| self.beside[i] * next);
            x[i] = inverses[i] * (x[i] - later);
        }
        x.iter().all(|v| v.iter().all(|c| c.is_finite())).then_some(x)
    }

    /// Blocks of the inverse: the covariance of each link, all others taken into account, and that with the next one.
    pub(crate) fn covariances(&self) -> Option<Covariances> {
        let mut diagonal = self.eliminated(0.0)?;
        let mut beside = vec![Matrix4::zeros(); self.beside.len()];
        for i in (0..diagonal.len().saturating_sub(1)).rev() {
            let gain = diagonal[i] * self.beside[i];
            beside[i] = -gain * diagonal[i + 1];
            let grown = diagonal[i] - beside[i] * gain.transpose();
            diagonal[i] = grown;
        }
        Some(Covariances { diagonal, beside })
    }
}

/// What is left unknown of a chain's links.
#[derive(Debug, Clone)]
pub(crate) struct Covariances {
    /// Of each link.
    pub diagonal: Vec<Matrix4<f64>>,
    /// Of link i with link i + 1.
    pub beside: Vec<Matrix4<f64>>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use planwalk_types::Seed;
    use rand::Rng;

    /// A chain of five links with random ties, and the same as a dense system.
    fn chain() -> (Chain, DMatrix<f64>, DVector<f64>) {
        let mut rng = Seed(5).derive("chain", 0);
        let mut random = move || (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let mut chain = Chain::zeros(5);
        for i in 0..5 {
            let root = Matrix4::from_fn(|_, _| random());
            chain.diagonal[i] = root * root.transpose() + Matrix4::identity() * 4.0;
            chain.right[i] = Vector4::from_fn(|_, _| random());
            if i > 0 {
                chain.beside[i - 1] = Matrix4::from_fn(|_, _| random());
            }
        }
        let mut dense = DMatrix::zeros(20, 20);
        for i in 0..5 {
            dense.view_mut((4 * i, 4 * i), (4, 4)).copy_from(&chain.diagonal[i]);
            if i > 0 {
                dense.view_mut((4 * i - 4, 4 * i), (4, 4)).copy_from(&chain.beside[i - 1]);
                dense.view_mut((4 * i, 4 * i - 4), (4, 4)).copy_from(&chain.beside[i - 1].transpose());
            }
        }
        let right = DVector::from_iterator(20, chain.right.iter().flat_map(|v| v.iter().copied()));
        (chain, dense, right)
    }

    #[test]
    fn a_chain_is_solved_as_the_dense_system_is() {
        let (chain, dense, right) = chain();
        let inverse = dense.clone().try_inverse().unwrap();
        let expected = &inverse * right;
        let solved = chain.solve(0.0).unwrap();
        let covariances = chain.covariances().unwrap();
        for i in 0..5 {
            for j in 0..4 {
                // Round-off of a well-conditioned system of 20.
                assert!((solved[i][j] - expected[4 * i + j]).abs() < 1e-12);
                for k in 0..4 {
                    assert!((covariances.diagonal[i][(j, k)] - inverse[(4 * i + j, 4 * i + k)]).abs() < 1e-12);
                    if i < 4 {
                        assert!((covariances.beside[i][(j, k)] - inverse[(4 * i + j, 4 * i + 4 + k)]).abs() < 1e-12);
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_not_positive_is_refused() {
        let (mut chain, ..) = chain();
        chain.diagonal[2] = -chain.diagonal[2];
        assert!(chain.solve(0.0).is_none() && chain.covariances().is_none());
        assert_eq!(Chain::zeros(0).solve(0.0), Some(Vec::new()));
    }
}
