#pragma once

#include "lab/moments.h"  // The product includes the laboratory.
