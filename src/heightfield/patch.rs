//! The bilinear patch over a cell: where a ray first meets it. In f64 for the reference, and in f32 as a twin of
//! `intersect_patch` in `shaders/march/max-mipmap.wgsl`.
//!
//! # The root, and its error
//!
//! The ray's height above the patch is F(t) = A·t² + B·t + C with C = F(0) > 0. The first root is taken in one of two
//! forms, chosen by the sign of B: neither then subtracts √D from a number of its own sign, so no digit of the root is
//! lost to cancellation, and A = 0 (a plane) needs no case of its own. What is left is the rounding of the coefficients
//! themselves. With u the unit roundoff and M = |C's terms| + |B's terms|·t + |A|·t², the computed root t* satisfies
//! |F(t*)| ≤ 16·u·M: it is the exact root of a patch that differs by no more than that in height. At a tangent, where
//! F′ = 0, the same bound on F leaves t* free within √(16·u·M / |A|); whether there is a root at all is free there, too.
//! `property_tests.rs` holds both precisions to this bound.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The numbers that a ray is cast in.
pub(super) trait Real:
    Copy
    + PartialOrd
    + From<u8>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The square root.
    fn root(self) -> Self;
    /// Neither NaN nor infinite.
    fn finite(self) -> bool;
}

impl Real for f32 {
    fn root(self) -> Self {
        self.sqrt()
    }

    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Real for f64 {
    fn root(self) -> Self {
        self.sqrt()
    }

    fn finite(self) -> bool {
        self.is_finite()
    }
}

/// First distance at which a ray is on or below the bilinear patch over the unit square.
///
/// `corners`: heights at (x, z) = (0, 0), (1, 0), (0, 1), (1, 1). `origin` and `direction` are x, y, z. The root may lie
/// beyond the square; NaN, infinite and negative ones are none.
pub(super) fn first_meeting<T: Real>([h00, h10, h01, h11]: [T; 4], origin: [T; 3], direction: [T; 3]) -> Option<T> {
    let [x, y, z] = origin;
    let [dx, dy, dz] = direction;
    let [zero, one, two, four] = [0, 1, 2, 4].map(T::from);
    let mix = |a: T, b: T, t: T| a * (one - t) + b * t;
    let constant = y - mix(mix(h00, h10, x), mix(h01, h11, x), z);
    if constant <= zero {
        return Some(zero);
    }
    let (a, b) = (h10 - h00, h01 - h00);
    let k = h00 - h10 - h01 + h11;
    let quadratic = -k * dx * dz;
    let linear = dy - a * dx - b * dz - k * (x * dz + z * dx);
    let discriminant = linear * linear - four * quadratic * constant;
    if discriminant < zero {
        return None;
    }
    let root = discriminant.root();
    let distance = if linear <= zero { two * constant / (root - linear) } else { -(linear + root) / (two * quadratic) };
    (distance.finite() && distance >= zero).then_some(distance)
}
