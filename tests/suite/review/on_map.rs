//! Boxes on the map, over the mosaic that they were found in.

use super::search::truth;
use super::*;
use bathyscope::app::{MapLayer, View};

#[test]
fn the_mosaic_with_boxes_looks_as_it_did() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut window = drawn_window([700.0, 500.0]);
    window.state_mut().show_alone(View::Map);
    window.state_mut().app.apply(Command::OpenDemo);
    window.run();
    let (names, found) = truth(&window);
    let review = Review::new(identity(&window), names.clone());
    let review = review.adopt("truth of the demo", &names, &found, &raster(&window), 0..usize::MAX);
    let path = folder.path().join("demo.review.json");
    fs::write(&path, review.to_json()).expect("a file");
    let app = app_mut(&mut window);
    app.apply(Command::OpenFile(FileToOpen::Review(path)));
    app.view.options.map.flat_spots = false;
    let layers = &mut app.view.options.map.layers;
    layers.set_visible(MapLayer::Mosaic, true);
    layers.set_visible(MapLayer::HillShade, false);
    layers.set_opacity(MapLayer::Track, 0.5);
    settle(&mut window);
    window.get_by_label_contains("boxes");
    window.snapshot("map_mosaic");
}
