#pragma once

// libtorch's tensors and gradients. With clang, 1.13's headers compile only when ivalue.h comes first.
#include <ATen/core/ivalue.h>
// (A blank comment keeps the order.)
#include <torch/types.h>
