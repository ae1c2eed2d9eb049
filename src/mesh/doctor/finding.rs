//! The kinds of defects and repairs, with their lasting names.

use std::fmt;

/// What was found in a soup.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FindingKind {
    /// There is no polygon.
    NoFaces,
    /// All used vertices lie at one place, or their extent is beyond what can be squared.
    NoExtent,
    /// Polygons that name a vertex twice in a row, or run out to a vertex and straight back.
    RepeatedVertices,
    /// Polygons that name the same vertices in the same or the opposite turn as an earlier one.
    DuplicateFaces,
    /// Polygons without area, those with repeated vertices included.
    DegenerateFaces,
    /// Edges with three or more sides.
    NonManifoldEdges,
    /// Vertices whose polygons form more than one fan (bow-ties).
    NonManifoldVertices,
    /// Parts of the surface with one side only (Möbius strip, Klein bottle). Edges: where orientation fails.
    NotOrientable,
    /// Edges that both neighbours run through in the same direction. Faces: the fewest to be turned.
    Orientation,
    /// Polygons whose triangles would name a vertex twice or have a side that belongs to something else.
    FoldedPolygons,
    /// Boundary vertices at one place, or nearly, that would close boundary edges if they were one.
    CoincidentVertices,
    /// Triangles with an angle below 1° or a height below a hundredth of the longest side. Worst: the smallest angle.
    Slivers,
    /// Closed components of negative volume. Faces: the first of each.
    InsideOut,
    /// The longest edge is very many times the shortest. Worst: the ratio.
    HugeRatio,
    /// The mesh lies many times its size away from the origin. Worst: the ratio.
    FarFromOrigin,
    /// Vertices that no polygon uses.
    Isolated,
    /// More than one component. Faces: the first of each.
    Components,
    /// Boundary loops. Edges: all boundary edges; the loops themselves are in the examination.
    BoundaryLoops,
}

impl FindingKind {
    /// The lasting name.
    pub fn id(self) -> &'static str {
        match self {
            Self::NoFaces => "no_faces",
            Self::NoExtent => "no_extent",
            Self::RepeatedVertices => "repeated_vertices",
            Self::DuplicateFaces => "duplicate_faces",
            Self::DegenerateFaces => "degenerate_faces",
            Self::NonManifoldEdges => "non_manifold_edges",
            Self::NonManifoldVertices => "non_manifold_vertices",
            Self::NotOrientable => "not_orientable",
            Self::Orientation => "orientation",
            Self::FoldedPolygons => "folded_polygons",
            Self::CoincidentVertices => "coincident_vertices",
            Self::Slivers => "slivers",
            Self::InsideOut => "inside_out",
            Self::HugeRatio => "huge_ratio",
            Self::FarFromOrigin => "far_from_origin",
            Self::Isolated => "isolated",
            Self::Components => "components",
            Self::BoundaryLoops => "boundary_loops",
        }
    }
}

/// How much a finding matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// No method can work on this.
    Blocks,
    /// Methods work, with results that may suffer.
    Warning,
    /// Good to know.
    Note,
}

/// One defect or property with all its places, in increasing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was found.
    pub kind: FindingKind,
    /// How much it matters.
    pub severity: Severity,
    /// In how many places; what is counted follows from the kind.
    pub count: usize,
    /// Vertices at fault.
    pub vertices: Vec<u32>,
    /// Edges at fault, smaller end first.
    pub edges: Vec<[u32; 2]>,
    /// Polygons at fault.
    pub faces: Vec<u32>,
    /// The worst value, where the kind has one.
    pub worst: Option<f64>,
    /// How many boundary edges a weld would close ([`FindingKind::CoincidentVertices`] only).
    pub closable: Option<usize>,
    /// What can be done, the best first.
    pub repairs: Vec<Repair>,
    /// Whether the first repair belongs to those that make a mesh solvable.
    pub recommended: bool,
}

impl Finding {
    /// A finding without places.
    pub fn new(kind: FindingKind, severity: Severity, count: usize) -> Self {
        Self {
            kind,
            severity,
            count,
            vertices: Vec::new(),
            edges: Vec::new(),
            faces: Vec::new(),
            worst: None,
            closable: None,
            repairs: Vec::new(),
            recommended: false,
        }
    }
}

/// What can be done to a soup. Displays as its lasting name, `keep_component:3`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Repair {
    /// Take repetitions and spikes out of polygons, and drop those that are no polygons then.
    DropRepeated,
    /// Drop polygons that an earlier one repeats.
    DropDuplicates,
    /// Drop or collapse polygons without area so that no hole opens.
    DropDegenerate,
    /// Merge boundary vertices that are closer than this part of the bounding box diagonal where that closes edges.
    Weld {
        /// Part of the bounding box diagonal; 0 for equal coordinates only.
        tolerance: f64,
    },
    /// Leave each edge to the two polygons that continue each other there.
    SplitEdges,
    /// Give each fan its own copy of the vertex.
    SplitVertices,
    /// Cut one-sided parts open where their orientation fails.
    OpenOneSided,
    /// Turn polygons so that neighbours agree and closed parts face outward.
    Orient,
    /// Replace polygons that cannot be triangulated as they are by triangles.
    SplitPolygons,
    /// Remove the vertices that no polygon uses. Renumbers.
    DropIsolated,
    /// Keep the component with the largest area.
    KeepLargest,
    /// Keep one component, as an examination numbers them.
    KeepComponent {
        /// Its number.
        component: u32,
    },
    /// Drop the components below a hundredth of the area.
    DropSmallComponents,
    /// Close holes by a polygon each.
    FillHoles {
        /// Only those with at most so many edges; all for `None`.
        max_edges: Option<u32>,
    },
    /// Turn all polygons.
    TurnInsideOut,
}

impl Repair {
    /// The lasting name.
    pub fn id(&self) -> String {
        self.to_string()
    }

    /// The repair of a lasting name.
    pub fn from_id(id: &str) -> Option<Self> {
        let (name, value) = match id.split_once(':') {
            Some((name, value)) => (name, Some(value)),
            None => (id, None),
        };
        let plain = match name {
            "drop_repeated" => Self::DropRepeated,
            "drop_duplicates" => Self::DropDuplicates,
            "drop_degenerate" => Self::DropDegenerate,
            "split_edges" => Self::SplitEdges,
            "split_vertices" => Self::SplitVertices,
            "open_one_sided" => Self::OpenOneSided,
            "orient" => Self::Orient,
            "split_polygons" => Self::SplitPolygons,
            "drop_isolated" => Self::DropIsolated,
            "keep_largest" => Self::KeepLargest,
            "drop_small_components" => Self::DropSmallComponents,
            "turn_inside_out" => Self::TurnInsideOut,
            "fill_holes" => {
                let max_edges = value.map(str::parse).transpose().ok()?;
                return Some(Self::FillHoles { max_edges });
            }
            "keep_component" => {
                return Some(Self::KeepComponent { component: value?.parse().ok()? });
            }
            "weld" => {
                let tolerance: f64 = value?.parse().ok()?;
                // Smaller tolerances than the rounding of coordinates are none.
                let is_part = tolerance.abs() <= 0.0 || (1e-12..1.0).contains(&tolerance);
                return is_part.then_some(Self::Weld { tolerance });
            }
            _ => return None,
        };
        value.is_none().then_some(plain)
    }
}

impl fmt::Display for Repair {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DropRepeated => f.write_str("drop_repeated"),
            Self::DropDuplicates => f.write_str("drop_duplicates"),
            Self::DropDegenerate => f.write_str("drop_degenerate"),
            Self::Weld { tolerance } => write!(f, "weld:{tolerance:e}"),
            Self::SplitEdges => f.write_str("split_edges"),
            Self::SplitVertices => f.write_str("split_vertices"),
            Self::OpenOneSided => f.write_str("open_one_sided"),
            Self::Orient => f.write_str("orient"),
            Self::SplitPolygons => f.write_str("split_polygons"),
            Self::DropIsolated => f.write_str("drop_isolated"),
            Self::KeepLargest => f.write_str("keep_largest"),
            Self::KeepComponent { component } => write!(f, "keep_component:{component}"),
            Self::DropSmallComponents => f.write_str("drop_small_components"),
            Self::FillHoles { max_edges: Some(n) } => write!(f, "fill_holes:{n}"),
            Self::FillHoles { max_edges: None } => f.write_str("fill_holes"),
            Self::TurnInsideOut => f.write_str("turn_inside_out"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_lasting_name_leads_back_to_its_repair() {
        for repair in [
            Repair::DropRepeated,
            Repair::DropDuplicates,
            Repair::DropDegenerate,
            Repair::Weld { tolerance: 0.0 },
            Repair::Weld { tolerance: 1e-6 },
            Repair::SplitEdges,
            Repair::SplitVertices,
            Repair::OpenOneSided,
            Repair::Orient,
            Repair::SplitPolygons,
            Repair::DropIsolated,
            Repair::KeepLargest,
            Repair::KeepComponent { component: 3 },
            Repair::DropSmallComponents,
            Repair::FillHoles { max_edges: None },
            Repair::FillHoles { max_edges: Some(12) },
            Repair::TurnInsideOut,
        ] {
            assert_eq!(Repair::from_id(&repair.id()), Some(repair));
        }
        assert_eq!(Repair::KeepComponent { component: 3 }.id(), "keep_component:3");
        assert_eq!(Repair::Weld { tolerance: 1e-6 }.id(), "weld:1e-6");
    }

    #[test]
    fn names_that_mean_nothing_are_refused() {
        for id in [
            "",
            "weld",
            "weld:",
            "weld:-1",
            "weld:nan",
            "weld:1",
            "weld:1e-300",
            "orient:2",
            "keep_component:x",
            "fill_holes:-1",
            "drop",
        ] {
            assert_eq!(Repair::from_id(id), None, "{id}");
        }
    }
}
