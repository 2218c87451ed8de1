//! egui only: reads state, pushes commands.
