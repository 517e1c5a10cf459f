#include "bus/log_damage.h"

#include "common/format.h"

namespace vantage {

std::string LogDamage::Place::Describe() const {
  std::string text;
  if (num_events == 0) {
    text = "between events";
  } else if (num_events == 1) {
    text = Format("event %jd", intmax_t{first_number});
  } else {
    text = Format(
        "events %jd to %jd", intmax_t{first_number}, intmax_t{first_number + num_events - 1});
  }
  text += Format(" at byte %jd: ", intmax_t{offset}) + reason;
  if (bytes == 0) return text + ", mended";
  text += Format(", %jd bytes skipped", intmax_t{bytes});
  return text;
}

std::string LogDamage::Describe() const {
  std::string text = Format("%jd bytes skipped in %jd places, %jd events lost",
                            intmax_t{bytes_skipped},
                            intmax_t{num_places},
                            intmax_t{events_lost});
  if (events_mended > 0) text += Format(", %jd events mended", intmax_t{events_mended});
  if (truncated) text += ", the file ends inside an event";
  if (!read_error.empty()) text += ", reading stopped: " + read_error;
  return text;
}

}  // namespace vantage
