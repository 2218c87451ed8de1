//! What the analyst sees and decides: state and commands. Knows no widget.
