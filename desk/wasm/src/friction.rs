//! Friction of two axes from recorded circles.
