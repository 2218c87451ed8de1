//! The writers of small files that tests of the readers have too.

#[path = "../../src/formats/cerulean/writer.rs"]
pub(super) mod cerulean_writer;
#[path = "../../src/formats/edgetech/writer.rs"]
pub(super) mod edgetech_writer;
#[path = "../../src/formats/garmin/tests/writer.rs"]
pub(super) mod garmin_writer;
#[path = "../suite/handmade.rs"]
pub(super) mod handmade;
#[path = "../../src/formats/klein/writer.rs"]
pub(super) mod klein_writer;
#[path = "../../src/formats/nmea/writer.rs"]
pub(super) mod nmea_writer;
