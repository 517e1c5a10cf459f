#pragma once

/// Both refinements of a pose: on points, then on pixels.
#include "perception/refinement/coarse_refinement.h"
#include "perception/refinement/refiner.h"
