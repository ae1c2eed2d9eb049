//! The parameters of phase fields and of developable patches.

use super::super::message::ParamSpec;
use super::super::specs::{choice, number, switch};

/// Phase fields, in the order of the panel. Lengths are for a surface of area 4π, that of the unit sphere.
pub fn phase_specs() -> Vec<ParamSpec> {
    [phase_segments(), phase_energy(), phase_solver()].concat()
}

fn phase_segments() -> Vec<ParamSpec> {
    let segments = "Segments";
    vec![
        number("levels", "Levels", "", "", [1.0, 5.0, 1.0], 2.0,
            "How often segments are divided in two: up to 2, 4, 8, 16 or 32 of them. Fewer takes divisions back, more divides what is there.")
            .group(segments).integer(),
        number("fraction", "First part", "", "%", [5.0, 95.0, 1.0], 50.0,
            "How much of a segment's area its first part gets. At 50 % both are equally large.")
            .group(segments),
        choice(segments, "phase_start", "Start",
            &[
                ("axes", "Axes of inertia"),
                ("random", "Random"),
                ("normals", "Normals"),
                ("painted", "Painted regions"),
            ],
            "What the first division starts from. With several starts, others follow, and the best is kept."),
        number("starts", "Starts", "", "", [1.0, 8.0, 1.0], 2.0,
            "Runs from different starts for each division; the one with the least energy is kept.")
            .group(segments).integer(),
        number("phase_seed", "Random seed", "", "", [0.0, 9999.0, 1.0], 1.0,
            "Another number gives other random starts.")
            .group(segments).integer().advanced(),
    ]
}

fn phase_energy() -> Vec<ParamSpec> {
    let energy = "Phase-field energy";
    vec![
        number("epsilon", "Interface width", "ε", "", [0.01, 0.5, 0.005], 0.12,
            "How wide the interface between two segments is, on a surface scaled to area 4π. It has to span two edges of the mesh.")
            .group(energy).logarithmic(),
        number("omega", "Distortion", "ω", "", [0.0, 20.0, 0.1], 1.0,
            "What the distortion of flattening (diffuse Yamabe energy) costs against the length of the interface. 0 asks for short cuts only.")
            .group(energy),
        switch(energy, "connected", "Connected segments", true,
            "Parts of a segment that fell apart are drawn together."),
        number("kappa", "Connectedness", "κ", "", [0.0, 4.0, 0.1], 2.0,
            "How much unconnected parts cost: the penalty's weight is ε to the power −κ.")
            .group(energy).advanced(),
        choice(energy, "screening", "Screening λ",
            &[
                ("outside", "1/ε², outside only"),
                ("sharp", "1/ε² (sharper)"),
                ("paper", "1/ε (paper)"),
            ],
            "How firmly the scale factor is held at 0 outside a segment. With the two others a field may turn grey inside a segment to look less distorted, and the border stays; the paper's choice converges only like the logarithm of ε.")
            .advanced(),
    ]
}

fn phase_solver() -> Vec<ParamSpec> {
    let solver = "Solver";
    vec![
        switch(solver, "relax", "Relax all levels", false,
            "At the end all divisions move together, ancestors too, instead of each staying where it was made.")
            .advanced(),
        number("warm_up", "Warm-up", "", "steps", [0.0, 200.0, 1.0], 25.0,
            "Steps of each division before connectedness is asked for.")
            .group(solver).integer().advanced(),
    ]
}

/// Developable patches, in the order of the panel.
pub fn develop_specs() -> Vec<ParamSpec> {
    let (charts, merging) = ("Flat pieces", "Merging");
    vec![
        number("vsa_tolerance", "Flatness", "", "", [0.0005, 0.1, 0.0001], 0.002,
            "How far normals of a first piece may be from their mean: squared difference times area, as a fraction of the surface. Smaller means more pieces to merge from.")
            .group(charts).logarithmic(),
        switch(charts, "min_cut", "Tighten seams", true,
            "Moves the borders of first pieces to creases and short ways, by minimal cuts."),
        switch(charts, "denoise", "Smooth seams", false,
            "Smooths the borders for merging. Exports keep the surface as it is.")
            .advanced(),
        choice(merging, "merge_measure", "Allow",
            &[
                ("absolute", "Area change anywhere"),
                ("total", "Area change in total (paper)"),
            ],
            "What merged pieces are tested by: change of area triangle by triangle, or of the piece as a whole, which growth here and shrinking there cancel out of."),
        number("area_limit", "Area change at most", "A", "%", [0.5, 50.0, 0.5], 10.0,
            "Pieces are not merged where flattening would change their area by more.")
            .group(merging),
        number("stretch_limit", "Stretch at most", "L²", "", [1.01, 4.0, 0.01], 2.0,
            "Pieces are not merged where flattening would stretch them by more: root mean square, 1 is true length.")
            .group(merging),
        number("patch_limit", "Largest piece", "", "%", [2.0, 100.0, 1.0], 100.0,
            "Pieces do not grow beyond this part of the surface: sheets and hides are only so large.")
            .group(merging),
        number("darts", "Darts", "", "", [0.0, 4.0, 1.0], 2.0,
            "Cuts from the border into a piece that would not flatten without, at most so many at a time. They save pieces and cost seam.")
            .group(merging).integer(),
        choice(merging, "merge_strategy", "Order",
            &[("best", "Best first"), ("paper", "Smallest area first (paper)")],
            "Best first tries all borders of two pieces together, least change of area for the longest seam first, until nothing more fits. The paper's way passes once.")
            .advanced(),
        number("improvements", "Improve", "", "rounds", [0.0, 3.0, 1.0], 1.0,
            "Afterwards each piece of a dozen parts or fewer is taken apart in turn and its parts are merged with its neighbours: kept where that takes fewer pieces or less seam. Not done where a symmetry is kept.")
            .group(merging).integer().advanced(),
        number("seam_price", "Hide seams", "", "", [0.0, 50.0, 0.5], 5.0,
            "By how many times its length a seam costs more where Hide is painted, or where it would be seen.")
            .group(merging).advanced(),
    ]
}
