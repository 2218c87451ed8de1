//! Places of the echoes of a survey on the bottom.

use super::Products;
use bathyscope_bottom::mosaic::MosaicLayout;
use bathyscope_log::support::geo::MapPlane;
use bathyscope_log::survey::Survey;

/// Computes the places of the echoes of a log in the plane of a map.
pub fn mosaic_layout(survey: &Survey, products: &Products, map: &MapPlane) -> MosaicLayout {
    let navigation = &products.navigation;
    mosaic_layout_by(survey, products, |[east_m, north_m]| {
        map.place(navigation.to_lon_lat(&survey.track, east_m, north_m))
    })
}

/// Computes the places of the echoes of a log in the plane that `place` leads to from that of the
/// survey.
pub fn mosaic_layout_by(
    survey: &Survey,
    products: &Products,
    place: impl Fn([f64; 2]) -> [f64; 2],
) -> MosaicLayout {
    MosaicLayout::new(
        survey,
        &products.navigation,
        &products.bottom_line,
        &products.calibration,
        &products.settings.mosaic,
        place,
    )
    .with_range_factor(products.correction.range_factor())
    .with_relief(&products.relief)
    .without(&products.exclusions)
}
