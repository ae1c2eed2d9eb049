//! Cutflow computes **where to cut a curved surface so that it flattens with little distortion**, and turns the pieces
//! into UV atlases and cutting patterns. The same engine runs in a browser tab and from a terminal.
//!
//! # Floors
//!
//! The crate is read from the ground up. A floor may only look down; `tests/it/tidy.rs` holds this table.
//!
//! | floor | module | what lives there |
//! |---|---|---|
//! | 0 | [`linalg`] | sparse symmetric systems: analyse once, factor often, solve often. Names the linear-algebra crate |
//! | 0 | [`mesh`] | connectivity, refinement along cuts, opening, reading mesh bytes ([`mesh::read`]), what is wrong with a mesh ([`mesh::doctor`]). Knows no metric |
//! | 1 | [`geometry`] | lengths, angles, curvature, cotan Laplacian, geodesic distance, nearest points, visibility, symmetries, intrinsic flips, [`geometry::doctor`] |
//! | 2 | [`methods`] | [`methods::flow`] (the `Flow` contract), [`methods::cutflow`] \[VSC\], [`methods::cones`] \[MAD\], [`methods::phasefield`] \[PF\], [`methods::developable`] (charts that are nearly flat \[LPFB\]), [`methods::cutgraph`] (disks, seams through cones), [`methods::straighten`] (outlines without zigzag, cuts along mesh edges), [`methods::prepare`] (finer, more even, lighter meshes) |
//! | 3 | [`flatten`] | patch → chart: BFF with isometric, scaled or chosen rims, conformal equivalence, LSCM, DCP, ABF++, fixed rims, isometric refinement; measures, overlaps, splitting, packing; charts → the surface that they make ([`flatten::fold`]) |
//! | 4 | [`pattern`] | chart → piece in millimetres: seams, allowance, notches, folds and flaps, nesting, sheet; bytes of SVG, DXF, PDF, OBJ, GLB, PLY, PNG, ZIP, JSON |
//! | 5 | [`session`] | commands in, events out: documents, parameters, undo, scenes, reports. The only serde |
//! | 6 | `viewer` | wgpu pictures of [`session::scene`]. Knows no geometry processing |
//! | 6 | `web` | two wasm files: `Engine` (worker, no graphics) and `Viewer` (page, no solvers) |
//! | 6 | `bin/cutflow` | the same session from a terminal |
//!
//! # From a file to a pattern
//!
//! bytes → [`mesh::Soup`] (the file as it stands, kept for exports) → [`geometry::doctor::examine`] (and repairs, soup to soup, and
//! [`methods::prepare`]) → [`mesh::Mesh`] + [`geometry::Geometry`] of unit area, without slivers where it has any →
//! [`methods::cutflow::CutFlow`] (labels and level sets) → [`mesh::CutMesh`] (the surface refined along the cut) →
//! [`methods::cutgraph`] (more cuts until all patches are disks) → [`methods::straighten`] → [`mesh::OpenedMesh`] → [`flatten::Flattening`] → packed
//! charts → [`pattern::Pattern`] → [`pattern::blanks`] (cut lines, notches, folds) → [`pattern::NestFlow`] (where they lie) → [`pattern::Sheet`] → files, and
//! [`session::Scene`] → pictures.
//!
//! # Invariants, stated as absences
//!
//! `mesh` knows no positions · nothing below `session` is serialisable · nothing below `web` knows a browser · the engine
//! reads no clock, opens no file, starts no thread, draws no random number of its own · the viewer knows no geometry
//! processing · the page knows no geometry · there is no global state.
//!
//! # Conventions
//!
//! f64, radians and model units in the engine; the flow works on a copy of unit area about the origin, and its weights are
//! for that. `twin(h) = h ^ 1`; faces are counter-clockwise seen from outside; the triangle (0,0) (1,0) (0,1) has area +½.
//! The cotan Laplacian is weak and positive semi-definite: L u = M f. Angle defects are integrated, face curvatures
//! pointwise. `u` is the log scale factor (length ratio eᵘ), negative level sets are inside.
//!
//! # Words
//!
//! **cut** on the surface · **patch** a part of the surface between cuts · **seam** a stretch of cut with its partner ·
//! **chart** a patch in the plane · **piece** a chart in millimetres · **crossing** where a cut meets an edge · **label** the
//! region of a vertex; several patches may share one · **rim** the outline of a patch.
//!
//! # Papers
//!
//! \[VSC\] Sharp, Crane: *Variational Surface Cutting*, 2018 · \[BFF\] Sawhney, Crane: *Boundary First Flattening*, 2017 ·
//! \[EW05\] Erickson, Whittlesey: *Greedy Optimal Homotopy and Homology Generators*, 2005 · \[KS98\] Kimmel, Sethian:
//! *Computing Geodesic Paths on Manifolds*, 1998 · \[PF\] Meny, Rumpf, Sassen: *A Phase-field Approach to Variational Hierarchical Surface Segmentation*, 2021 · \[MAD\] Soliman, Slepčev, Crane: *Optimal Cone Singularities for Conformal Flattening*, 2018 · \[SSGH01\] Sander et al.: *Texture Mapping Progressive Meshes*, 2001 · \[CAD04\] Cohen-Steiner, Alliez, Desbrun: *Variational Shape
//! Approximation*, 2004 · \[KT03\] Katz, Tal: *Hierarchical Mesh Decomposition using Fuzzy Clustering and Cuts*, 2003.

pub mod flatten;
pub mod geometry;
pub mod linalg;
pub mod mesh;
pub mod methods;
pub mod pattern;
pub mod session;
#[cfg(feature = "viewer")]
pub mod viewer;
#[cfg(any(feature = "engine", feature = "viewer"))]
pub mod web;
