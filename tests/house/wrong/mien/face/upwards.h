#pragma once

// A header that looks upwards, for the test of the test: the check over includes must refuse this tree.
#include "mien/take/take.h"
