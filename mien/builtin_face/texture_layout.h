#pragma once

#include "mien/face/face.h"

namespace mien::builtin_face {

/// Lays the skin, lips and eyeballs of a built-in face out on one square picture: its texture coordinates
/// (uv, (0, 0) the picture's upper left) are what they were for strands and in the picture for these. No two
/// places of them share one of the picture, but for the caps behind the eyeballs, which are turned over.
/// Above, the skin from crown to neck, unrolled about the head's axis: u 0.5 is the middle of the face and
/// the performer's left lies right of it; the seam is at the back, where a vertex has u 1 and triangles on
/// the performer's right mean 0. A millimetre of the face is wider there than one of scalp and neck. Below,
/// ears and eyeballs, each a disc. Other parts stay at (0, 0).
void lay_out_textures(face::Face& builtin);

}  // namespace mien::builtin_face
