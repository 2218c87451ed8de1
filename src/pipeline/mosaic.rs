//! Where the echoes of a survey lie on the ground.

use super::Products;
use crate::geo::MapPlane;
use crate::mosaic::Layout;
use crate::survey::Survey;

/// Where the echoes of a result fall in the plane of a map.
pub fn mosaic_layout(survey: &Survey, products: &Products, map: &MapPlane) -> Layout {
    let navigation = &products.navigation;
    Layout::new(
        survey,
        navigation,
        &products.returns,
        &products.calibration,
        &products.settings.mosaic,
        |[east_m, north_m]| map.place(navigation.to_lon_lat(&survey.track, east_m, north_m)),
    )
    .with_range_factor(products.correction.range_factor())
    .without(&products.left_out)
}
