//! Friction of two axes and their drives' figures from recorded circles.
