//! The tools that hang on the wall: closed convex meshes made by code, none of them read from a file.
//!
//! The measures are round ones of common tools, of no particular make. As an [`super::Orientation`] of zero holds them:
//! width lies along x with the working edge at its lower end, towards the axis; thickness along y, length along z.
//! Invariant: every tool here passes the checks of [`ConvexTool::new`]; `tests/tests/clay/polygonal_tools.rs` holds them to
//! their measures.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::f32::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};
use once_cell::race::OnceBox;

use super::{ConvexError, ConvexTool};
use crate::units::Metres;

/// Rib, blade, knuckle and loop, in the order of [`super::Shape`]: made when they are first asked for, and shared by all who ask.
#[must_use]
pub fn standard() -> Arc<[ConvexTool]> {
    static STANDARD: OnceBox<Arc<[ConvexTool]>> = OnceBox::new();
    // their measures are fixed, so that none is refused
    let made = || Box::new([rib(), blade(), knuckle(), loop_end()].into_iter().flatten().collect());
    Arc::clone(STANDARD.get_or_init(made))
}

/// A kidney rib with its hollow side filled: half a disc of 100 × 50 mm, 4 mm thick, its edges bevelled.
///
/// # Errors
/// None: the measures are fixed; an error would be a fault of [`ConvexTool::new`].
pub fn rib() -> Result<ConvexTool, ConvexError> {
    const ARC: usize = 17;
    let outline = (0..ARC).map(|at| {
        let (sin, cos) = libm::sincosf(PI * at as f32 / (ARC - 1) as f32);
        Vec2::new(50.0 * sin - 25.0, -50.0 * cos)
    });
    let outline: Vec<Vec2> = outline.collect();
    let layers = [(-2.0, 0.96), (-1.0, 1.0), (1.0, 1.0), (2.0, 0.96)];
    stack(&layers.map(|(height, scale)| ring(&outline, height, scale)))
}

/// A potter's wooden knife: 150 mm long and 20 mm wide, 6 mm thick at the back and 0.5 mm at its straight edge.
///
/// # Errors
/// As for [`rib`].
pub fn blade() -> Result<ConvexTool, ConvexError> {
    let profile = [[-3.0, -10.0], [3.0, -10.0], [3.0, 0.0], [0.25, 10.0], [-0.25, 10.0], [-3.0, 0.0]];
    let end = |z: f32| profile.map(|[thick, edgeward]| Vec3::new(-edgeward, thick, z)).to_vec();
    stack(&[end(-75.0), end(75.0)])
}

/// The knuckle of a bent finger: an ellipsoid of 20 × 18 × 28 mm in 320 facets, as large as its smooth one.
///
/// # Errors
/// As for [`rib`].
pub fn knuckle() -> Result<ConvexTool, ConvexError> {
    // a linear map keeps what is convex convex
    let half_axes_m = DVec3::new(0.010, 0.009, 0.014);
    ConvexTool::new(&scaled(&unit_ball(2), half_axes_m))
}

/// The end of a trimming loop, filled: wire of 3 mm bent to a ring of 30 mm outer diameter.
///
/// The hull of a torus: its outer half, closed by two discs.
///
/// # Errors
/// As for [`rib`].
pub fn loop_end() -> Result<ConvexTool, ConvexError> {
    const ROUND: usize = 32;
    const WIRE: usize = 6;
    let circle: Vec<Vec2> = (0..ROUND)
        .map(|at| {
            let (sin, cos) = libm::sincosf(TAU * at as f32 / ROUND as f32);
            Vec2::new(cos, sin)
        })
        .collect();
    let layers: Vec<Vec<Vec3>> = (0..=WIRE)
        .map(|at| {
            let (sin, cos) = libm::sincosf(PI * (at as f32 / WIRE as f32 - 0.5));
            ring(&circle, 1.5 * sin, 13.5 + 1.5 * cos)
        })
        .collect();
    stack(&layers)
}

/// A sphere as a mesh of 20·4ⁿ facets, n subdivisions of an icosahedron, with the volume of the sphere of `radius`.
///
/// With its corners on the sphere it would lie inside everywhere and press less deep by the height of its facets; with
/// the same volume it lies as much outside as inside, and its mean depth is the sphere's.
///
/// # Errors
/// [`ConvexError::TooMany`] for more than five subdivisions, [`ConvexError::Size`] or [`ConvexError::Thin`] for a radius
/// out of range.
pub fn ball(subdivisions: u32, radius: Metres) -> Result<ConvexTool, ConvexError> {
    let facets = 4_usize.saturating_pow(subdivisions).saturating_mul(20);
    if facets > ConvexTool::TRIANGLES_MAX {
        let (min, max) = (ConvexTool::TRIANGLES_MIN, ConvexTool::TRIANGLES_MAX);
        return Err(ConvexError::TooMany { triangles: facets, min, max });
    }
    ConvexTool::new(&scaled(&unit_ball(subdivisions), DVec3::splat(f64::from(radius.0))))
}

/// An outline over x and z at a height against y, scaled about the origin; mm.
fn ring(outline: &[Vec2], height: f32, scale: f32) -> Vec<Vec3> {
    outline.iter().map(|point| Vec3::new(point.x * scale, -height, point.y * scale)).collect()
}

/// The solid between rings of equally many corners, mm, one upon the other, each counter-clockwise about the way up.
fn stack(rings: &[Vec<Vec3>]) -> Result<ConvexTool, ConvexError> {
    let mut triangles = Vec::new();
    for pair in rings.windows(2) {
        let (lower, upper) = (&pair[0], &pair[1]);
        for at in 0..lower.len() {
            let next = (at + 1) % lower.len();
            triangles.push([lower[at], lower[next], upper[next]]);
            triangles.push([lower[at], upper[next], upper[at]]);
        }
    }
    if let (Some(bottom), Some(top)) = (rings.first(), rings.last()) {
        let turned: Vec<Vec3> = bottom.iter().rev().copied().collect();
        close(&turned, &mut triangles);
        close(top, &mut triangles);
    }
    let in_metres = |corner: Vec3| corner.map(|mm| Metres::from_mm(mm).0);
    ConvexTool::new(&triangles.into_iter().map(|triangle| triangle.map(in_metres)).collect::<Vec<_>>())
}

/// Closes a ring, counter-clockwise seen from outside: by halves, so that a way across meets few triangles.
fn close(ring: &[Vec3], triangles: &mut Vec<[Vec3; 3]>) {
    if let [first, .., last] = ring
        && ring.len() > 2
    {
        let middle = ring.len() / 2;
        triangles.push([*first, ring[middle], *last]);
        close(&ring[..=middle], triangles);
        close(&ring[middle..], triangles);
    }
}

/// An icosahedron, each facet divided into four `subdivisions` times, with the volume of the unit sphere.
fn unit_ball(subdivisions: u32) -> Vec<[DVec3; 3]> {
    let mut triangles = icosahedron();
    for _ in 0..subdivisions {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [a + b, b + c, c + a].map(onto_sphere);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let six_volumes: f64 = triangles.iter().map(|[a, b, c]| a.dot(b.cross(*c))).sum();
    let scale = libm::cbrt(8.0 * core::f64::consts::PI / six_volumes);
    triangles.iter().map(|triangle| triangle.map(|corner| corner * scale)).collect()
}

fn onto_sphere(point: DVec3) -> DVec3 {
    point / libm::sqrt(point.length_squared())
}

/// Twelve corners on three golden rectangles, and the twenty triangles of corners that are an edge apart.
fn icosahedron() -> Vec<[DVec3; 3]> {
    let golden = (1.0 + libm::sqrt(5.0)) / 2.0;
    let signs = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)];
    let corners: Vec<DVec3> = signs
        .into_iter()
        .map(|(short, long)| (short, golden * long))
        .flat_map(|(s, l)| [DVec3::new(0.0, s, l), DVec3::new(s, l, 0.0), DVec3::new(l, 0.0, s)])
        .collect();
    let edge_squared = 4.0;
    let mut triangles = Vec::new();
    for (first, &a) in corners.iter().enumerate() {
        for (second, &b) in corners.iter().enumerate().skip(first + 1) {
            for &c in &corners[second + 1..] {
                let is_facet = [a - b, b - c, c - a].iter().all(|side| side.length_squared() < 1.1 * edge_squared);
                if is_facet {
                    let faces_outwards = a.dot(b.cross(c)) > 0.0;
                    triangles.push(if faces_outwards { [a, b, c] } else { [a, c, b] }.map(onto_sphere));
                }
            }
        }
    }
    triangles
}

fn scaled(triangles: &[[DVec3; 3]], half_axes_m: DVec3) -> Vec<[Vec3; 3]> {
    triangles.iter().map(|triangle| triangle.map(|corner| (corner * half_axes_m).as_vec3())).collect()
}
