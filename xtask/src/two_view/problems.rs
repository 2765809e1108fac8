//! What does a file of two-view problems hold? NumPy's `.npz`: matches of two pictures, and how the camera truly moved.
//!
//! | array | shape | content |
//! |---|---|---|
//! | `x1`, `x2` | P × N × 2 | matches, pixels |
//! | `K` | 3 × 3 | the camera of both pictures |
//! | `R`, `t` | P × 3 × 3, P × 3 | the motion: a point X of camera 1 is R X + t in camera 2 |
//! | `scen`, `scen_names` | P, S | which scenario a problem is of, and what they are called |

use std::fs::File;
use std::path::Path;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector2, Vector3};
use npyz::{Deserialize, NpyFile};
use zip::ZipArchive;
use zip::read::ZipFile;

/// One pair of pictures.
pub struct Problem {
    /// Index of its scenario.
    pub scenario: usize,
    /// Matches, pixels.
    pub matches: Vec<(Vector2<f64>, Vector2<f64>)>,
    /// True rotation, camera 2 from camera 1.
    pub rotation: UnitQuaternion<f64>,
    /// True translation; zero where the camera only turned.
    pub translation: Vector3<f64>,
}

/// All of a file.
pub struct Problems {
    /// Names of the scenarios.
    pub scenarios: Vec<String>,
    /// Intrinsics of both pictures.
    pub camera: Matrix3<f64>,
    /// In the file's order.
    pub problems: Vec<Problem>,
}

type Archive = ZipArchive<File>;

/// Reads a file of problems.
pub fn read(path: &Path) -> Result<Problems, String> {
    let told = |why: &dyn std::fmt::Display| format!("the problems cannot be read: {why}\n  {}", path.display());
    let file = File::open(path).map_err(|why| told(&why))?;
    let mut archive = ZipArchive::new(file).map_err(|why| told(&why))?;
    of_archive(&mut archive).map_err(|why| told(&why))
}

fn of_archive(archive: &mut Archive) -> Result<Problems, String> {
    let (x1, shape) = floats(archive, "x1")?;
    let (x2, shape2) = floats(archive, "x2")?;
    let [count, matches, 2] = shape[..] else { return Err(format!("x1 has the shape {shape:?}, not problems × matches × 2")) };
    if shape != shape2 {
        return Err(format!("x1 has the shape {shape:?}, but x2 {shape2:?}"));
    }
    let camera = Matrix3::from_row_slice(&of_length(archive, "K", 9)?);
    let rotations = of_length(archive, "R", 9 * count)?;
    let translations = of_length(archive, "t", 3 * count)?;
    let scenario_of = of_length(archive, "scen", count)?;
    let scenarios: Vec<String> = open(archive, "scen_names")?.into_vec().map_err(|why| format!("scen_names: {why}"))?;
    let problem = |i: usize| {
        let pixel = |x: &[f64], k: usize| Vector2::new(x[2 * (matches * i + k)], x[2 * (matches * i + k) + 1]);
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_row_slice(&rotations[9 * i..9 * i + 9]));
        let scenario = scenario_of[i] as usize;
        if scenario >= scenarios.len() {
            return Err(format!("problem {i} is of the scenario {scenario}, but there are {}", scenarios.len()));
        }
        Ok(Problem {
            scenario,
            matches: (0..matches).map(|k| (pixel(&x1, k), pixel(&x2, k))).collect(),
            rotation: UnitQuaternion::from_rotation_matrix(&rotation),
            translation: Vector3::from_column_slice(&translations[3 * i..3 * i + 3]),
        })
    };
    let problems = (0..count).map(problem).collect::<Result<_, String>>()?;
    Ok(Problems { scenarios, camera, problems })
}

fn open<'a>(archive: &'a mut Archive, name: &str) -> Result<NpyFile<ZipFile<'a, File>>, String> {
    let entry = archive.by_name(&format!("{name}.npy")).map_err(|why| format!("no array {name}: {why}"))?;
    NpyFile::new(entry).map_err(|why| format!("{name}: {why}"))
}

fn of_length(archive: &mut Archive, name: &str, count: usize) -> Result<Vec<f64>, String> {
    let (values, shape) = floats(archive, name)?;
    if values.len() == count { Ok(values) } else { Err(format!("{name} has the shape {shape:?}: {count} numbers are needed")) }
}

/// Numbers of any of the usual types, and their shape.
fn floats(archive: &mut Archive, name: &str) -> Result<(Vec<f64>, Vec<usize>), String> {
    let file = open(archive, name)?;
    let (shape, order, kind): (Vec<usize>, _, _) = (file.shape().iter().map(|n| *n as usize).collect(), file.order(), file.dtype().descr());
    drop(file);
    if order != npyz::Order::C && shape.len() > 1 {
        return Err(format!("{name} is in Fortran's order: save it with numpy.ascontiguousarray"));
    }
    let values = if let Some(values) = of_type(archive, name, |v: f64| v)? {
        values
    } else if let Some(values) = of_type(archive, name, |v: f32| f64::from(v))? {
        values
    } else if let Some(values) = of_type(archive, name, |v: i64| v as f64)? {
        values
    } else if let Some(values) = of_type(archive, name, |v: i32| f64::from(v))? {
        values
    } else {
        return Err(format!("{name} is of the type {kind}, not of float or int"));
    };
    if values.len() == shape.iter().product::<usize>() { Ok((values, shape)) } else { Err(format!("{name} breaks off")) }
}

/// All numbers, if they are of this type. What breaks off is short.
fn of_type<T: Deserialize>(archive: &mut Archive, name: &str, to: impl Fn(T) -> f64) -> Result<Option<Vec<f64>>, String> {
    let numbers = open(archive, name)?.data::<T>();
    Ok(numbers.ok().map(|numbers| numbers.map_while(Result::ok).map(to).collect()))
}
