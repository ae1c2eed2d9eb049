//! The stage as a whole: what is made again after what, and what lies under the pointer.

use super::super::cones;
use super::super::fixtures::{overlapping_squares, two_squares, unit_ball};
use super::*;
use crate::session::scene::FieldScene;

pub(super) fn stage(scene: Scene) -> Stage {
    let mut stage = Stage::default();
    for view in View::ALL {
        stage.resize(view, Viewport { size: Vec2::new(500.0, 300.0), scale: 1.0 });
    }
    stage.set_scene(scene).expect("a good scene");
    stage
}

fn changed(stage: &mut Stage, scene: Scene) -> Vec<usize> {
    let before = stage.stamps;
    stage.set_scene(scene).expect("a good scene");
    (0..Part::COUNT).filter(|&part| before[part] != stage.stamps[part]).collect()
}

#[test]
fn only_what_changed_is_made_again() {
    let mut stage = stage(two_squares());
    let mut scene = Scene { revision: 1, ..two_squares() };
    // NaN is no change.
    scene.charts[0] = f32::NAN;
    scene.patches[0].anchor = [f32::NAN; 2];
    stage.set_scene(scene.clone()).expect("a good scene");
    assert_eq!(changed(&mut stage, scene.clone()), [0; 0]);

    scene.values = vec![0.5; 8];
    scene.field = Some(FieldScene::default());
    assert_eq!(
        changed(&mut stage, scene.clone()),
        [Part::Paint, Part::Ramp].map(|part| part as usize)
    );
    assert!(stage.shows_field());

    scene.positions[2] = 0.125;
    // What hides a cone lies elsewhere as well.
    let moved = [Part::Geometry, Part::Cuts, Part::Outline, Part::Wires, Part::Cones]
        .map(|part| part as usize);
    assert_eq!(changed(&mut stage, scene.clone()), moved);

    stage.set_hover(Some(1));
    stage.set_hover(Some(1));
    assert_eq!(changed(&mut stage, scene), [0; 0]);
}

#[test]
fn the_camera_returns_with_the_first_scene_of_a_mesh_and_with_no_other() {
    let mut stage = stage(two_squares());
    let first = stage.orbit;
    stage.rotate(Vec2::new(30.0, 10.0));
    stage.pan(View::Flat, Vec2::new(5.0, 0.0));
    let (turned, moved) = (stage.orbit, stage.sheet);
    stage.set_scene(Scene { revision: 7, ..two_squares() }).expect("a good scene");
    assert_eq!((stage.orbit, stage.sheet), (turned, moved));
    stage.set_scene(Scene { revision: 2, ..two_squares() }).expect("a good scene");
    assert_eq!(stage.orbit, first);
    assert_ne!(stage.sheet, moved);
}

#[test]
fn the_sheet_follows_the_layout_until_it_is_moved() {
    let mut stage = stage(two_squares());
    let scene =
        |width, revision| Scene { sheet: [0.0, 0.0, width, 1.0], revision, ..two_squares() };
    stage.set_scene(scene(9.0, 1)).expect("a good scene");
    let fitted = stage.chart_pixels_per_unit();
    assert!((fitted - 492.0 / 9.0).abs() < 1e-3);
    stage.zoom(View::Flat, 2.0, Vec2::new(1.0, 1.0));
    stage.set_scene(scene(2.0, 2)).expect("a good scene");
    assert!((stage.chart_pixels_per_unit() - 2.0 * fitted).abs() < 1e-3);
    stage.fit(View::Flat);
    assert!((stage.chart_pixels_per_unit() - 492.0 / 2.0).abs() < 1e-3);
}

#[test]
fn pointing_at_the_middle_of_a_ball_meets_its_near_side() {
    let mut stage = stage(unit_ball(3, 0));
    let pick = stage.pick(View::Surface, Vec2::new(250.0, 150.0)).expect("the ball");
    assert!((pick.place.length() - 1.0).abs() < 0.02);
    let eye = stage.projection(View::Surface).eye;
    assert!(pick.place.normalize().dot(eye.normalize()) > 0.999);
    assert_eq!(pick.face, pick.triangle);
    assert_eq!(stage.pick(View::Surface, Vec2::new(3.0, 3.0)), None);
    // It has no charts.
    assert_eq!(stage.pick(View::Flat, Vec2::new(250.0, 150.0)), None);
}

#[test]
fn the_brush_lies_where_it_points_and_is_drawn_anew_only_when_it_moves() {
    let mut stage = stage(unit_ball(3, 0));
    let middle = Vec2::new(250.0, 150.0);
    assert!(stage.set_brush(middle, 0.2));
    assert_eq!(stage.bytes(Part::Brush).len(), stage.ring.len() * 60);
    let towards_eye = stage.eye().normalize();
    for point in &stage.ring {
        // A facet of the ball lies up to a fiftieth inside it.
        assert!((point.length() - 1.0).abs() < 0.03);
        assert!((point.reject_from(towards_eye).length() - 0.2).abs() < 0.02);
    }
    let stamp = stage.stamp_of(Part::Brush);
    stage.take_dirty(View::Surface);
    stage.set_brush(middle, 0.2);
    assert_eq!((stage.stamp_of(Part::Brush), stage.take_dirty(View::Surface)), (stamp, false));
    assert!(!stage.set_brush(Vec2::new(3.0, 3.0), 0.2));
    assert!(stage.take_dirty(View::Surface) && stage.bytes(Part::Brush).is_empty());
}

#[test]
fn a_stroke_across_the_ball_stays_on_it() {
    let mut stage = stage(unit_ball(3, 0));
    let mut dabs = stage.stroke(Vec2::new(250.0, 150.0), 0.1, true);
    assert_eq!(dabs.len(), 1);
    dabs.extend(stage.stroke(Vec2::new(300.0, 150.0), 0.1, false));
    assert!(dabs.len() > 3);
    for pair in dabs.windows(2) {
        assert!(pair[0].place.distance(pair[1].place) < 0.1, "a gap");
    }
    assert!(dabs.iter().all(|dab| (dab.place.length() - 1.0).abs() < 0.03));
    assert_eq!(stage.stroke(Vec2::new(3.0, 3.0), 0.1, true), []);
    assert_eq!(stage.stroke(Vec2::NAN, 0.1, false), []);
}

/// The ball with a cone at each pole: one looks at the eye from above the middle, one is behind.
fn ball_with_cones() -> Scene {
    let ball = unit_ball(3, 0);
    let at = |place: Vec3| {
        let points: &[[f32; 3]] = ball.positions.as_chunks().0;
        (0..)
            .zip(points)
            .find(|(_, p)| Vec3::from_array(**p).distance(place) < 1e-5)
            .expect("a pole")
            .0
    };
    Scene {
        cone_points: vec![0.0, 0.0, 1.0, 0.0, 0.0, -1.0],
        cone_angles: vec![1.0, -2.0],
        cone_charts: vec![at(Vec3::Z), 0, at(Vec3::NEG_Z), 1],
        ..ball
    }
}

#[test]
fn a_cone_is_picked_where_it_is_seen_and_not_through_the_surface() {
    let mut stage = stage(ball_with_cones());
    let (projection, viewport) = (stage.projection(View::Surface), stage.viewport(View::Surface));
    let near = cones::to_screen(Vec3::Z, &projection, viewport).expect("in front");
    let far = cones::to_screen(Vec3::NEG_Z, &projection, viewport).expect("in front");
    assert_eq!(stage.pick_cone(View::Surface, near + Vec2::new(3.0, 0.0), 2.0), Some(0));
    assert_eq!(stage.pick_cone(View::Surface, near + Vec2::new(30.0, 0.0), 2.0), None);
    assert_eq!(stage.pick_cone(View::Surface, far, 2.0), None);
    assert_eq!(stage.pick_cone(View::Surface, Vec2::NAN, 2.0), None);
    // It has no charts.
    assert_eq!(stage.pick_cone(View::Flat, near, 500.0), None);
    let labels = stage.cone_labels(View::Surface);
    assert_eq!(labels.len(), 1, "the cone behind has no label: {labels:?}");
    assert_eq!(stage.bytes(Part::Cones).len(), 28, "and no glyph");
    assert!(labels[0][0] < 0.5 && Vec2::new(labels[0][1], labels[0][2]).distance(near) < 1e-3);
}

#[test]
fn a_cone_behind_comes_into_sight_as_the_surface_turns() {
    let mut stage = stage(ball_with_cones());
    let front = stage.bytes(Part::Cones);
    let stamp = stage.stamp_of(Part::Cones);
    // Half a turn for the shorter side of the view.
    stage.rotate(Vec2::new(300.0, 0.0));
    assert_ne!(stage.stamp_of(Part::Cones), stamp);
    let back = stage.bytes(Part::Cones);
    assert!(back.len() == 28 && back != front, "the other cone alone");
    assert!(stage.cone_labels(View::Surface)[0][0] > 0.5, "its label is that of cone 1");
}

#[test]
fn a_dragged_cone_follows_and_returns_when_it_is_dropped() {
    let mut stage = stage(ball_with_cones());
    let still = stage.bytes(Part::Cones);
    let pick = stage.drag_cone(0, View::Surface, Vec2::new(250.0, 150.0)).expect("the ball");
    assert_eq!(stage.glyphs(View::Surface)[0].place, pick.place);
    assert_eq!(stage.drag_cone(0, View::Surface, Vec2::new(3.0, 3.0)), None);
    assert_ne!(stage.bytes(Part::Cones), still, "beside the surface it stays where it was last");
    // A scene that says nothing new of the cones leaves the hand alone.
    stage.set_scene(Scene { revision: 1, ..ball_with_cones() }).expect("a good scene");
    assert_ne!(stage.bytes(Part::Cones), still);
    stage.drop_cone();
    assert_eq!(stage.bytes(Part::Cones), still);
    stage.drag_cone(0, View::Surface, Vec2::new(250.0, 150.0));
    let mut moved = Scene { revision: 2, ..ball_with_cones() };
    moved.cone_points[0] = 0.25;
    stage.set_scene(moved).expect("a good scene");
    assert!((stage.glyphs(View::Surface)[0].place.x - 0.25).abs() < 1e-6);
}

#[test]
fn marks_on_cones_are_drawn_once_and_come_first_among_labels() {
    let mut stage = stage(ball_with_cones());
    let stamp = stage.stamp_of(Part::ChartCones);
    let marks = Marks { selected: 0, ..Marks::default() };
    stage.set_cone_marks(marks);
    stage.set_cone_marks(marks);
    assert_eq!(stage.stamp_of(Part::ChartCones), stamp + 1);
    assert!(!stage.cone_labels(View::Surface).is_empty());
}

#[test]
fn pointing_at_a_chart_gives_the_place_on_the_surface() {
    let mut stage = stage(two_squares());
    let css = stage.sheet.to_screen(Vec2::new(1.75, 0.25), stage.viewport(View::Flat));
    let pick = stage.pick(View::Flat, css).expect("the second square");
    assert_eq!((pick.patch, pick.triangle, pick.face), (1, 2, 1));
    assert!(pick.place.distance(Vec3::new(0.5, 0.25, 0.0)) < 1e-4);
}

#[test]
fn numbers_stand_on_their_charts_and_hide_where_they_do_not_fit() {
    let mut stage = stage(two_squares());
    let anchors = stage.anchors();
    let scale = stage.chart_pixels_per_unit();
    let expected = stage.sheet.to_screen(Vec2::splat(0.5), stage.viewport(View::Flat));
    assert!(Vec2::new(anchors[0], anchors[1]).distance(expected) < 1e-3);
    assert!((anchors[2] - scale).abs() < 1e-2);
    stage.zoom(View::Flat, 0.08, Vec2::new(250.0, 150.0));
    assert!(stage.anchors().iter().all(|x| x.is_nan()));
}

#[test]
#[expect(clippy::float_cmp, reason = "the same number comes back")]
fn cells_have_the_size_that_is_asked_for_and_else_one_that_suits_the_surface() {
    let mut stage = stage(two_squares());
    let usual = 2.0_f32.sqrt() / TEXTURE_CELLS;
    assert!((stage.usual_cell() - usual).abs() < 1e-6);
    for senseless in [f32::NAN, f32::INFINITY, 0.0, -1.0, 1e-9] {
        stage.set_texture(Texture::Grid, senseless);
        assert_eq!(stage.cell(), stage.usual_cell(), "{senseless}");
    }
    stage.set_texture(Texture::Circles, 0.125);
    assert_eq!((stage.texture(), stage.cell()), (Texture::Circles, 0.125));
    assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [true, true]);
    stage.set_texture(Texture::Circles, 0.125);
    assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [false, false]);
    assert_eq!(Texture::from_name("houndstooth"), None);
}

#[test]
fn overlapping_charts_take_the_place_of_pieces_until_a_field_is_shown_or_pieces_are_wanted() {
    let mut stage = stage(two_squares());
    let pieces = stage.chart_pixels_per_unit();
    assert!(!stage.shows_layers());
    let scene = Scene { revision: 1, ..overlapping_squares() };
    let parts = changed(&mut stage, scene.clone());
    let layers =
        [Part::LayerVertices, Part::LayerTriangles, Part::LayerChartTriangles, Part::LayerRims];
    assert_eq!(parts, layers.map(|part| part as usize));
    assert_eq!(changed(&mut stage, scene.clone()), [0; 0]);
    // Another sheet is shown, and its charts are no pieces to point at.
    assert!(stage.shows_layers() && stage.chart_pixels_per_unit() < pieces);
    assert_eq!(stage.pick(View::Flat, Vec2::new(250.0, 150.0)), None);
    assert_eq!(stage.anchors().len(), 6);
    stage.set_layer_mode(LayerMode::Hard);
    assert!(stage.shows_layers());
    stage.set_layer_mode(LayerMode::Pieces);
    assert!(!stage.shows_layers());
    assert!((stage.chart_pixels_per_unit() - pieces).abs() < 1e-3);
    stage.set_layer_mode(LayerMode::Blended);
    let field = Some(FieldScene::default());
    stage.set_scene(Scene { values: vec![0.5; 8], field, ..scene }).expect("a good scene");
    assert!(!stage.shows_layers());
    assert!((stage.chart_pixels_per_unit() - pieces).abs() < 1e-3);
}

#[test]
fn pixels_are_made_when_they_are_wanted_and_an_image_waits_for_its_own() {
    let mut stage = stage(two_squares());
    assert_eq!(stage.pixels(), None);
    stage.set_texture(Texture::Image, 0.1);
    assert_eq!((stage.texture(), stage.pixels()), (Texture::None, None));
    let image = Pixels::from_rgba(2, 1, &[9; 8]).expect("an image");
    let stamp = stage.stamp_of(Part::Pixels);
    stage.set_image(image.clone());
    assert_eq!((stage.texture(), stage.pixels()), (Texture::Image, Some(&image)));
    assert!(stage.stamp_of(Part::Pixels) > stamp);
    assert_eq!(stage.bytes(Part::Pixels).len(), 12);
    stage.set_texture(Texture::Spots, 0.1);
    assert_ne!(stage.pixels(), Some(&image));
    assert_eq!(stage.texture(), Texture::Spots);
    let stamp = stage.stamp_of(Part::Pixels);
    stage.set_texture(Texture::Spots, 0.2);
    assert_eq!(stage.stamp_of(Part::Pixels), stamp);
}

#[test]
fn a_view_is_dirty_once_and_only_where_something_moved() {
    let mut stage = stage(two_squares());
    assert!(View::ALL.map(|view| stage.take_dirty(view)).iter().all(|&dirty| dirty));
    stage.rotate(Vec2::new(1.0, 0.0));
    assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [true, false]);
    stage.rotate(Vec2::new(f32::NAN, 0.0));
    assert_eq!(View::ALL.map(|view| stage.take_dirty(view)), [false, false]);
}

#[test]
fn a_broken_scene_leaves_the_stage_as_it_was() {
    let mut stage = stage(two_squares());
    let broken = Scene { triangles: vec![0, 1, 77], ..two_squares() };
    assert!(stage.set_scene(broken).is_err());
    assert_eq!(*stage.scene(), two_squares());
}

#[test]
fn a_large_mesh_is_shaded_over_several_pictures() {
    let mut ball = unit_ball(5, 0);
    // As many vertices again, inside: more than are looked at for one picture.
    ball.positions.extend(ball.positions.clone().iter().map(|x| 0.5 * x));
    ball.normals.extend_from_within(..);
    ball.charts.extend_from_within(..);
    ball.vertex_patches.extend_from_within(..);
    ball.values.extend_from_within(..);
    let mut stage = stage(ball);
    let mut pictures = Vec::new();
    while pictures.is_empty() || stage.take_dirty(View::Surface) {
        stage.take_dirty(View::Surface);
        let stamp = stage.stamp_of(Part::Geometry);
        pictures.push(stage.bytes(Part::Geometry));
        let is_last = stage.stamp_of(Part::Geometry) == stamp;
        assert_eq!(is_last, !stage.dirty[View::Surface as usize], "what is new is drawn");
    }
    assert_eq!(pictures.len(), 2);
    assert_ne!(pictures[0], pictures[1]);
    assert_eq!(stage.bytes(Part::Geometry), pictures[1]);
}
