//! The parameters of optimal cones.

use super::super::message::ParamSpec;
use super::super::specs::{choice, number, switch};

/// The table, in the order of the panel.
pub fn specs() -> Vec<ParamSpec> {
    [sparsity(), angles(), surface(), solver()].concat()
}

/// How much angle there may be.
fn sparsity() -> Vec<ParamSpec> {
    let sparsity = "Sparsity";
    vec![
        choice(sparsity, "choose_by", "Choose by",
            &[
                ("lambda", "Cone cost λ"),
                ("count", "Number of cones"),
                ("exactly", "Exact number of cones"),
                ("angle", "Total angle"),
                ("distortion", "Distortion"),
            ],
            "What is given: the price of angle, or what it should lead to; the price is then found on the path of optima. Where no price leads to few cones, an exact number of them is put where they do most."),
        number("lambda", "Cone cost", "λ", "", [1e-4, 0.2, 1e-4], 0.005,
            "Price of a radian of cone angle against ½∫u² on a surface of unit area. A smaller price gives more cones and less distortion.")
            .group(sparsity).logarithmic().only_if("choose_by", &["lambda"]),
        number("cone_count", "Cones at most", "", "", [0.0, 400.0, 1.0], 8.0,
            "The smallest price is taken that leads to no more cones than this, merged ones counted once.")
            .group(sparsity).integer().only_if("choose_by", &["count"]),
        number("exact_count", "Cones", "", "", [0.0, 400.0, 1.0], 8.0,
            "So many cones, their places found by local search from the merged cones of an optimum, their angles those that distort least. Nothing proves that no other places are better.")
            .group(sparsity).integer().only_if("choose_by", &["exactly"]),
        number("angle_target", "Total angle", "Φ", "π", [0.0, 40.0, 0.05], 4.0,
            "Sum of the cones' angles without their signs. A closed surface of genus 0 has at least 4 π.")
            .group(sparsity).only_if("choose_by", &["angle"]),
        number("distortion_target", "Distortion ∫u²", "E", "", [1e-4, 2.0, 1e-4], 0.1,
            "The largest price is taken that leads to no more distortion than this.")
            .group(sparsity).logarithmic().only_if("choose_by", &["distortion"]),
    ]
}

/// What angles may be, and where they are wanted.
fn angles() -> Vec<ParamSpec> {
    let angles = "Angles";
    vec![
        choice(angles, "bounds", "Bounds",
            &[
                ("free", "Free"),
                ("positive", "≥ 0"),
                ("quarter", "± π/2"),
                ("custom", "Custom"),
            ],
            "What the angle of one cone may be. Without negative cones charts cannot overlap themselves around one."),
        number("angle_min", "Smallest angle", "", "π", [-2.0, 0.0, 0.05], -0.5,
            "No cone has a smaller angle; −2 π sets no bound.")
            .group(angles).only_if("bounds", &["custom"]),
        number("angle_max", "Largest angle", "", "π", [0.0, 2.0, 0.05], 0.5,
            "No cone has a larger angle; 2 π sets no bound.")
            .group(angles).only_if("bounds", &["custom"]),
        number("importance", "Painted importance", "w_E", "", [1.0, 1000.0, 0.1], 20.0,
            "How many times as much distortion counts where importance is painted with the brush.")
            .group(angles).logarithmic(),
        number("dear_cones", "Painted cone cost", "w_R", "", [1.0, 1000.0, 0.1], 20.0,
            "How many times as much cones cost where their cost is painted, or where they would be seen.")
            .group(angles).logarithmic(),
        number("feature_weight", "Feature weight", "", "", [0.0, 1.0, 0.05], 0.0,
            "Makes distortion count more, and cones cheaper, where the surface is finely shaped. 1 is the paper's choice, 0 leaves it out.")
            .group(angles),
    ]
}

/// What the surface asks for, and what is made of the cones.
fn surface() -> Vec<ParamSpec> {
    let surface = "Surface";
    vec![
        choice(surface, "boundary", "Boundary",
            &[
                ("isometric", "True length (u = 0)"),
                ("optimal", "Best length"),
                ("polygonal", "Polygon: corners cost"),
                ("convex", "Convex"),
                ("polygonal_convex", "Convex polygon"),
            ],
            "What the flattened boundary has to be. Closed surfaces have none."),
        number("corner_cost", "Cost of corners", "λ_B", "λ", [0.05, 20.0, 0.05], 1.0,
            "Price of angle at corners of a polygonal boundary, against that inside.")
            .group(surface).logarithmic().only_if("boundary", &["polygonal", "polygonal_convex"]),
        switch(surface, "round", "Merge clusters", true,
            "Neighbouring vertices that share a cone become one. What this costs is told."),
        switch(surface, "debias", "Refit angles", false,
            "The optimum's places are kept and their angles chosen anew for least distortion, whatever angle that takes."),
        number("seam_hiding", "Hide seams", "", "", [0.0, 50.0, 0.5], 5.0,
            "By how many times its length a seam costs more where Hide is painted, or where it would be seen.")
            .group(surface),
    ]
}

fn solver() -> Vec<ParamSpec> {
    let solver = "Solver";
    vec![
        choice(solver, "cone_method", "Solver",
            &[
                ("auto", "By predicted cost"),
                ("greens", "Green’s functions"),
                ("newton", "Semismooth Newton"),
            ],
            "Both find the same optimum: Green’s functions are fast for up to some hundred cones, Newton’s method for more.")
            .advanced(),
        switch(solver, "multiresolution", "Start on a coarser mesh", false,
            "Looks for the places of cones on a coarser copy first. The result is the same.")
            .advanced(),
    ]
}
