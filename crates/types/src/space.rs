//! Which frame is this point in? Marker types and points that wear them.

use std::fmt;
use std::marker::PhantomData;

/// The floor plan: metres, x right, y up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plan {}
/// Where the odometry began: z up, the odometry's own unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Odom {}
/// The walker: x forward, y left, z up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {}
/// The camera: x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cam {}

/// A point on the floor in frame `F`.
pub struct Pt2<F> {
    /// First coordinate.
    pub x: f64,
    /// Second coordinate.
    pub y: f64,
    frame: PhantomData<fn() -> F>,
}

/// A point in space in frame `F`.
pub struct Pt3<F> {
    /// The coordinates.
    pub coords: nalgebra::Vector3<f64>,
    frame: PhantomData<fn() -> F>,
}

impl<F> Pt2<F> {
    /// The point (x, y).
    pub const fn new(x: f64, y: f64) -> Self {
        Self { x, y, frame: PhantomData }
    }

    /// Euclidean distance to another point of the same frame.
    pub fn distance(self, other: Self) -> f64 {
        (self.x - other.x).hypot(self.y - other.y)
    }
}

impl<F> Pt3<F> {
    /// The point (x, y, z).
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self::from_vector(nalgebra::Vector3::new(x, y, z))
    }

    /// The point with these coordinates.
    pub const fn from_vector(coords: nalgebra::Vector3<f64>) -> Self {
        Self { coords, frame: PhantomData }
    }
}

// Derives would ask the markers for the same traits.
impl<F> Clone for Pt2<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Pt2<F> {}
impl<F> PartialEq for Pt2<F> {
    fn eq(&self, other: &Self) -> bool {
        self.x == other.x && self.y == other.y
    }
}
impl<F> fmt::Debug for Pt2<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {})", self.x, self.y)
    }
}
impl<F> Clone for Pt3<F> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<F> Copy for Pt3<F> {}
impl<F> PartialEq for Pt3<F> {
    fn eq(&self, other: &Self) -> bool {
        self.coords == other.coords
    }
}
impl<F> fmt::Debug for Pt3<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "({}, {}, {})", self.coords.x, self.coords.y, self.coords.z)
    }
}
