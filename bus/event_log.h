#pragma once

#include "bus/event_log_reader.h"  // IWYU pragma: export
#include "bus/event_log_writer.h"  // IWYU pragma: export
