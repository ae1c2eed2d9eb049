//! What a person can ask of a pattern, as parameters; what trades usually ask.

use super::super::message::{ParamSpec, Value};
use super::super::specs::{choice, number, switch};

/// Groups of these parameters begin so: the page shows them with the preview of the sheet.
const SEAMS: &str = "Pattern: Seams";
const MARKS: &str = "Pattern: Marks";
const PAPER: &str = "Pattern: Folds and flaps";
const PIECES: &str = "Pattern: Pieces";
const SHEET: &str = "Pattern: Sheet";
const FILES: &str = "Pattern: Files";

/// All parameters of patterns and their files, in the order of the panel.
pub fn specs() -> Vec<ParamSpec> {
    [seams(), marks(), paper(), pieces(), sheet(), files()].concat()
}

fn seams() -> Vec<ParamSpec> {
    vec![
        number("allowance", "Seam allowance", "", "mm", [0.0, 100.0, 0.5], 0.0,
            "What is left outside the sewing line. Every seam can have one of its own in the list of seams.")
            .group(SEAMS),
        switch(SEAMS, "rim_allowance", "Allowance on open rims", true,
            "Whether the rim of the surface itself, where nothing is sewn on, gets the allowance too: a hem."),
        choice(SEAMS, "corner", "Corners",
            &[("mitre", "Mitred"), ("round", "Round"), ("square", "Square")],
            "How the allowance goes around a corner. Mitres longer than two and a half allowances are cut off."),
        choice(SEAMS, "notches", "Notches",
            &[("none", "None"), ("slit", "Slit"), ("v", "V"), ("t", "T")],
            "Marks that meet when two pieces are sewn: at the same lengths along the seam on the surface, in groups that tell seams and directions apart."),
        number("notch_spacing", "Notch spacing", "", "mm", [5.0, 500.0, 1.0], 60.0,
            "About how far notches are from one another.")
            .group(SEAMS).logarithmic().only_if("notches", &["slit", "v", "t"]),
    ]
}

fn marks() -> Vec<ParamSpec> {
    vec![
        switch(
            MARKS,
            "seam_labels",
            "Seam labels",
            true,
            "What each seam is sewn to, beside it: 12 > B is seam 12, sewn to piece B.",
        ),
        switch(MARKS, "piece_labels", "Piece names", true, "Name and number in each piece."),
        switch(
            MARKS,
            "marks",
            "Inner marks",
            true,
            "Tips of darts, ends of seams, and places where three or more pieces meet.",
        ),
        switch(
            MARKS,
            "hints",
            "Hints",
            false,
            "How much each piece has to stretch, and how tightly it is bent.",
        ),
        choice(
            MARKS,
            "grain",
            "Grain line",
            &[("none", "None"), ("both", "Either way"), ("nap", "One way (nap)")],
            "Along the grain of the material, from the lower to the upper side of the sheet.",
        ),
    ]
}

fn paper() -> Vec<ParamSpec> {
    vec![
        switch(
            PAPER,
            "folds",
            "Fold lines",
            false,
            "Where the surface turns by more than the angle below: mountains dash-dotted, valleys dashed.",
        ),
        number(
            "fold_angle",
            "Least angle",
            "",
            "°",
            [1.0, 90.0, 1.0],
            5.0,
            "Flatter folds are left out.",
        )
        .group(PAPER)
        .only_if("folds", &["true"]),
        choice(
            PAPER,
            "flaps",
            "Glue flaps",
            &[
                ("none", "None"),
                ("alternate", "Alternating"),
                ("smaller", "On the smaller piece"),
                ("both", "On both sides"),
            ],
            "Flaps on one of the two sides of each seam, narrow enough to lie under the other.",
        ),
        number("flap_depth", "Flap depth", "", "mm", [1.0, 50.0, 0.5], 8.0, "How far flaps reach.")
            .group(PAPER)
            .only_if("flaps", &["alternate", "smaller", "both"]),
        number(
            "flap_angle",
            "Flap angle",
            "",
            "°",
            [20.0, 80.0, 1.0],
            50.0,
            "Between the base of a flap and its ends; smaller where there is no room.",
        )
        .group(PAPER)
        .advanced()
        .only_if("flaps", &["alternate", "smaller", "both"]),
    ]
}

fn pieces() -> Vec<ParamSpec> {
    vec![
        number("copies", "Copies", "", "", [1.0, 100.0, 1.0], 1.0, "How often each piece is cut.")
            .group(PIECES).integer(),
        switch(PIECES, "mirrored", "Mirrored copies too", false,
            "As many mirrored copies of each piece: linings, or the other half of a pair."),
        choice(PIECES, "outlines", "Outlines",
            &[("exact", "Exact polylines"), ("smooth", "Smooth curves")],
            "Smooth curves run within the tolerance of the exact outline; corners and ends of seams stay."),
        number("curve_tolerance", "Tolerance", "", "mm", [0.01, 2.0, 0.01], 0.1,
            "How far smooth curves may be off.")
            .group(PIECES).logarithmic().only_if("outlines", &["smooth"]),
        number("kerf", "Kerf", "", "mm", [0.0, 5.0, 0.01], 0.0,
            "What the tool takes away: outlines are moved out by half of it, holes in. 0 leaves this to the machine.")
            .group(PIECES).advanced(),
    ]
}

fn sheet() -> Vec<ParamSpec> {
    vec![
        choice(
            SHEET,
            "stock",
            "Material",
            &[("free", "No limit"), ("roll", "Roll"), ("sheet", "Sheets")],
            "What pieces are cut from: they are nested on a roll as short as possible, or on as few sheets as possible.",
        ),
        number(
            "stock_width",
            "Width",
            "",
            "mm",
            [10.0, 20000.0, 1.0],
            1400.0,
            "Of the roll, or of a sheet.",
        )
        .group(SHEET)
        .logarithmic()
        .only_if("stock", &["roll", "sheet"]),
        number("stock_height", "Height", "", "mm", [10.0, 20000.0, 1.0], 1000.0, "Of a sheet.")
            .group(SHEET)
            .logarithmic()
            .only_if("stock", &["sheet"]),
        number(
            "gap",
            "Gap",
            "",
            "mm",
            [0.0, 100.0, 0.5],
            5.0,
            "Least distance between two pieces.",
        )
        .group(SHEET),
        number(
            "stock_margin",
            "Margin",
            "",
            "mm",
            [0.0, 200.0, 1.0],
            10.0,
            "Free space at the edges of the sheet.",
        )
        .group(SHEET),
        choice(
            SHEET,
            "turns",
            "Pieces may be turned",
            &[
                ("free", "Freely"),
                ("quarter", "By quarters"),
                ("half", "By half a turn (woven)"),
                ("none", "Not at all (nap)"),
            ],
            "What the grain of the material allows.",
        ),
    ]
}

fn files() -> Vec<ParamSpec> {
    vec![
        choice(FILES, "svg_profile", "SVG for",
            &[("print", "Print"), ("laser", "Laser")],
            "Laser: hairlines in the machine's colours, inner cuts first, words as lines, no dashes."),
        choice(FILES, "dxf_profile", "DXF for",
            &[
                ("plain", "Any program"),
                ("exploded", "Any program, without blocks"),
                ("astm", "Garment systems (ASTM D6673)"),
                ("gerber", "Garment systems (Gerber)"),
            ],
            "Blocks keep pieces together; some machines read no blocks."),
        switch(FILES, "dxf_unit", "DXF says millimetres", true,
            "Writes the unit into the header, which R12 itself does not know: without it programs take 1 unit as 1 mm, or ask.")
            .advanced(),
        choice(FILES, "paper", "PDF paper",
            &[
                ("a4", "A4"),
                ("a3", "A3"),
                ("letter", "Letter"),
                ("one", "One page"),
            ],
            "The pattern is spread over pages of this size, to be put together."),
        number("page_overlap", "Overlap", "", "mm", [0.0, 30.0, 1.0], 12.0,
            "What neighbouring pages share; 0 joins them edge to edge.")
            .group(FILES).only_if("paper", &["a4", "a3", "letter"]),
        choice(FILES, "uv_texture", "Texture in GLB",
            &[("checker", "Checkerboard"), ("atlas", "Pieces, baked")],
            "A picture for the UV map of the GLB: checks show the stretch; baked pieces show what goes where."),
        choice(FILES, "uv_pixels", "Texture size",
            &[("1024", "1024 px"), ("2048", "2048 px"), ("4096", "4096 px")],
            "Side of the baked texture, and of what the margin of UV maps is measured in.")
            .advanced(),
        number("uv_margin", "UV margin", "", "px", [1.0, 64.0, 1.0], 8.0,
            "Least distance between two pieces of a UV map.")
            .group(FILES).integer().advanced(),
    ]
}

/// Usual settings of a trade: identifier, name, what for, values.
pub type Trade = (&'static str, &'static str, &'static str, Vec<(&'static str, Value)>);

/// The trades. What a trade does not name goes back to its default.
pub fn trades() -> Vec<Trade> {
    let number = Value::Number;
    let text = |word: &str| Value::Text(word.into());
    let on = Value::Truth(true);
    vec![
        ("plain", "Outlines", "Outlines and names only", vec![]),
        (
            "plush",
            "Plush",
            "6 mm, outward notches, pile one way",
            vec![
                ("allowance", number(6.0)),
                ("notches", text("v")),
                ("notch_spacing", number(40.0)),
                ("grain", text("nap")),
                ("turns", text("none")),
                ("outlines", text("smooth")),
            ],
        ),
        (
            "garment",
            "Garment",
            "10 mm, slits, woven cloth",
            vec![
                ("allowance", number(10.0)),
                ("notches", text("slit")),
                ("notch_spacing", number(80.0)),
                ("grain", text("both")),
                ("turns", text("half")),
                ("outlines", text("smooth")),
                ("stock", text("roll")),
            ],
        ),
        (
            "upholstery",
            "Upholstery",
            "13 mm, V notches, roll",
            vec![
                ("allowance", number(13.0)),
                ("notches", text("v")),
                ("notch_spacing", number(80.0)),
                ("grain", text("both")),
                ("turns", text("half")),
                ("outlines", text("smooth")),
                ("stock", text("roll")),
            ],
        ),
        (
            "leather",
            "Leather",
            "5 mm, no slits",
            vec![
                ("allowance", number(5.0)),
                ("notches", text("t")),
                ("notch_spacing", number(60.0)),
                ("outlines", text("smooth")),
                ("gap", number(3.0)),
            ],
        ),
        (
            "paper",
            "Paper model",
            "Folds and glue flaps on A4",
            vec![
                ("folds", on.clone()),
                ("flaps", text("alternate")),
                ("marks", Value::Truth(false)),
                ("turns", text("free")),
                ("gap", number(4.0)),
                ("stock", text("sheet")),
                ("stock_width", number(190.0)),
                ("stock_height", number(265.0)),
                ("stock_margin", number(0.0)),
                ("page_overlap", number(0.0)),
            ],
        ),
        (
            "sheet_metal",
            "Sheet metal",
            "Cut and bend lines, sheets of 2 × 1 m",
            vec![
                ("folds", on),
                // Softer bends are rolled, not folded: their radius is told.
                ("fold_angle", number(15.0)),
                ("outlines", text("smooth")),
                ("curve_tolerance", number(0.05)),
                ("svg_profile", text("laser")),
                ("stock", text("sheet")),
                ("stock_width", number(2000.0)),
                ("stock_height", number(1000.0)),
                ("turns", text("free")),
            ],
        ),
    ]
}
