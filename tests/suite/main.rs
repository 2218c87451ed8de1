//! One test binary: building and linking it once is what keeps CI short.
//! A module a room; `support` finds the real recordings and simulated surveys.

mod architecture;
mod base_map;
mod bathymetry;
mod calibration;
mod cli;
mod cloud;
mod corrected;
mod crs;
mod damage;
mod dataset;
mod detection_metrics;
mod detection_targets;
mod detector;
mod export;
mod first_return;
mod formats;
mod garbled;
mod golden;
mod handmade;
mod map_layers;
mod map_tools;
mod missions;
mod mosaic;
mod navigation;
mod real_window;
mod review;
mod river;
mod shipped_model;
mod simulation;
mod space;
mod support;
mod truth;
mod waterfall;
mod window;
mod window_job;
