// The description file, one setting a line, words separated by blanks, "#" begins a comment. It is
// read again whenever it changes, so write it beside and rename it over the old one.
//
//   device N                 begins the device /dev/videoN; it is unplugged when this is gone
//   kind capture             or: output, metadata (V4L2 devices that are no cameras), null (a
//                            character device of another kind), file (a regular file)
//   driver NAME, card TEXT   as VIDIOC_QUERYCAP tells them
//   serial TEXT              of the USB device; without it there is none
//   port P, index I          place of the USB device (default: N) and of the node in it (0)
//   speed S                  frames come S times as often as the rate says; stamps keep true time
//   format FOURCC WxH R...   a mode with its rates in Hz, each "30" or "30000/1001"; repeated
//   stepwise FOURCC WxH WxH STEP R...      all sizes from one to the other
//   control NAME MIN MAX STEP INITIAL      a name of control_table.cc
//   frames FILE              raw frames of the image's size, in turn, instead of the pattern
//   padding N                N bytes after each row
//   jpeg_tables no           JPEGs without Huffman tables, as many webcams send them
//   fail CALL ERRNO [TIMES]  OPEN, MMAP, DQBUF, S_FMT...: fails, TIMES times or always
//   override FIELD VALUE     the device answers this for: width, height, pixelformat, bytesperline,
//                            sizeimage, buffer_count, buffer_length, interval_numerator,
//                            interval_denominator
//   fault NAME [VALUE] [every N | at N | after N]   of all frames, every N-th, only number N, or
//                            number N and later, counted from 0 at STREAMON:
//     stall                  none comes
//     drop                   is counted but does not come
//     bytesused V            is told to have V bytes
//     error_flag             is marked V4L2_BUF_FLAG_ERROR
//     corrupt V              has every third byte from number V on inverted
//     sequence V             has V added to its number
//     stamp V                has V us added to its stamp
//     stamp_still            has the first frame's stamp
//     poll_error, poll_hangup                while it is awaited, poll() says POLLERR (and POLLHUP)
//   fault NAME               of the whole device:
//     endless                enumerations of formats, sizes, rates and controls never end
//     unterminated           strings fill their fields without a 0 at the end
#include "tests/drivers/v4l2_shim/description.h"

#include <linux/videodev2.h>

#include <cerrno>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

namespace vantage::v4l2_shim {
namespace {

using Words = std::vector<std::string>;

uint32_t Number(const std::string& word) {
  size_t end = 0;
  const unsigned long value = std::stoul(word, &end, 0);
  if (end != word.size() || value > UINT32_MAX) throw std::runtime_error("no number: " + word);
  return static_cast<uint32_t>(value);
}

uint32_t FourCc(const std::string& word) {
  std::string code = word;
  code.resize(4, ' ');
  return v4l2_fourcc(code[0], code[1], code[2], code[3]);
}

void ReadSize(const std::string& word, uint32_t* width, uint32_t* height) {
  const size_t x = word.find('x');
  if (x == std::string::npos) throw std::runtime_error("no size: " + word);
  *width = Number(word.substr(0, x));
  *height = Number(word.substr(x + 1));
}

Fraction ReadRate(const std::string& word) {
  const size_t slash = word.find('/');
  if (slash == std::string::npos) return {Number(word), 1};
  return {Number(word.substr(0, slash)), Number(word.substr(slash + 1))};
}

void Expect(const Words& words, size_t count) {
  if (words.size() < count) throw std::runtime_error("too few words");
}

FormatMode ReadFormat(const Words& words, bool stepwise) {
  Expect(words, stepwise ? 6 : 4);
  FormatMode mode;
  mode.fourcc = FourCc(words[1]);
  mode.stepwise = stepwise;
  ReadSize(words[2], &mode.width, &mode.height);
  size_t next = 3;
  if (stepwise) {
    ReadSize(words[3], &mode.max_width, &mode.max_height);
    mode.step = Number(words[4]);
    next = 5;
  }
  for (; next < words.size(); ++next) mode.rates.push_back(ReadRate(words[next]));
  return mode;
}

int ErrorNumber(const std::string& name) {
  static const std::map<std::string, int> kNumbers = {{"EACCES", EACCES},
                                                      {"EAGAIN", EAGAIN},
                                                      {"EBUSY", EBUSY},
                                                      {"EINVAL", EINVAL},
                                                      {"EIO", EIO},
                                                      {"EMFILE", EMFILE},
                                                      {"ENODEV", ENODEV},
                                                      {"ENOENT", ENOENT},
                                                      {"ENOMEM", ENOMEM},
                                                      {"ENOSPC", ENOSPC},
                                                      {"ENOTTY", ENOTTY},
                                                      {"EPERM", EPERM},
                                                      {"EPROTO", EPROTO},
                                                      {"ERANGE", ERANGE}};
  const auto found = kNumbers.find(name);
  if (found == kNumbers.end()) throw std::runtime_error("unknown error: " + name);
  return found->second;
}

When ReadWhen(const Words& words, size_t first) {
  if (first >= words.size()) return {};
  Expect(words, first + 2);
  static const std::map<std::string, When::Kind> kKinds = {
      {"every", When::Kind::kEvery}, {"at", When::Kind::kAt}, {"after", When::Kind::kAfter}};
  const auto kind = kKinds.find(words[first]);
  if (kind == kKinds.end()) throw std::runtime_error("no such time: " + words[first]);
  return {kind->second, Number(words[first + 1])};
}

FrameFault ReadFault(const Words& words) {
  static const std::set<std::string> kPlain = {"stall",
                                               "drop",
                                               "error_flag",
                                               "stamp_still",
                                               "poll_error",
                                               "poll_hangup",
                                               "endless",
                                               "unterminated"};
  static const std::set<std::string> kWithValue = {"bytesused", "corrupt", "sequence", "stamp"};
  Expect(words, 2);
  FrameFault fault;
  fault.name = words[1];
  size_t next = 2;
  if (kWithValue.contains(fault.name)) {
    Expect(words, 3);
    fault.value = std::stoll(words[next++], nullptr, 0);
  } else if (!kPlain.contains(fault.name)) {
    throw std::runtime_error("no such fault: " + fault.name);
  }
  fault.when = ReadWhen(words, next);
  return fault;
}

Override ReadOverride(const Words& words) {
  static const std::set<std::string> kFields = {"width",
                                                "height",
                                                "pixelformat",
                                                "bytesperline",
                                                "sizeimage",
                                                "buffer_count",
                                                "buffer_length",
                                                "interval_numerator",
                                                "interval_denominator"};
  Expect(words, 3);
  if (!kFields.contains(words[1])) throw std::runtime_error("no such field: " + words[1]);
  return {words[1], words[1] == "pixelformat" ? FourCc(words[2]) : Number(words[2])};
}

Device::Kind ReadKind(const std::string& word) {
  static const std::map<std::string, Device::Kind> kKinds = {{"capture", Device::Kind::kCapture},
                                                             {"output", Device::Kind::kOutput},
                                                             {"metadata", Device::Kind::kMetadata},
                                                             {"null", Device::Kind::kNull},
                                                             {"file", Device::Kind::kFile}};
  const auto found = kKinds.find(word);
  if (found == kKinds.end()) throw std::runtime_error("no such kind: " + word);
  return found->second;
}

ControlValue ReadControl(const Words& words) {
  Expect(words, 6);
  const auto number = [&words](size_t i) { return std::stoi(words[i]); };
  return {words[1], number(2), number(3), number(4), number(5)};
}

void ReadLine(const std::string& line, const Words& words, Device* device) {
  const std::string& key = words[0];
  Expect(words, 2);
  const std::string rest = line.substr(line.find(words[1], line.find(key) + key.size()));
  if (key == "kind") {
    device->kind = ReadKind(words[1]);
  } else if (key == "driver") {
    device->driver = rest;
  } else if (key == "card") {
    device->card = rest;
  } else if (key == "serial") {
    device->serial = rest;
  } else if (key == "port") {
    device->port = static_cast<int>(Number(words[1]));
  } else if (key == "index") {
    device->index = static_cast<int>(Number(words[1]));
  } else if (key == "speed") {
    device->speed = std::stod(words[1]);
  } else if (key == "jpeg_tables") {
    device->jpeg_tables = words[1] != "no";
  } else if (key == "padding") {
    device->padding_bytes = Number(words[1]);
  } else if (key == "frames") {
    device->frames_file = rest;
  } else if (key == "format" || key == "stepwise") {
    device->formats.push_back(ReadFormat(words, key == "stepwise"));
  } else if (key == "control") {
    device->controls.push_back(ReadControl(words));
  } else if (key == "fault") {
    device->faults.push_back(ReadFault(words));
  } else if (key == "fail") {
    Expect(words, 3);
    const int times = words.size() > 3 ? static_cast<int>(Number(words[3])) : 0;
    device->fails.push_back({words[1], ErrorNumber(words[2]), times, line});
  } else if (key == "override") {
    device->overrides.push_back(ReadOverride(words));
  } else {
    throw std::runtime_error("unknown key " + key);
  }
}

}  // namespace

bool When::Includes(uint64_t frame) const {
  switch (kind) {
    case Kind::kAlways:
      return true;
    case Kind::kEvery:
      return number > 0 && frame % number == number - 1;
    case Kind::kAt:
      return frame == number;
    case Kind::kAfter:
      return frame >= number;
  }
  return false;
}

std::string Device::bus() const { return "usb-0000:00:14.0-" + std::to_string(port + 1); }

uint32_t Device::Answer(const std::string& field, uint32_t value) const {
  for (const Override& each : overrides) {
    if (each.field == field) return each.value;
  }
  return value;
}

const FrameFault* Device::Fault(const std::string& name, uint64_t frame) const {
  for (const FrameFault& fault : faults) {
    if (fault.name == name && fault.when.Includes(frame)) return &fault;
  }
  return nullptr;
}

std::vector<Device> ParseDescription(const std::string& text) {
  std::vector<Device> devices;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line = line.substr(0, line.find('#'));
    const size_t last = line.find_last_not_of(" \t\r");
    if (last == std::string::npos) continue;
    line.resize(last + 1);
    std::istringstream split(line);
    Words words;
    for (std::string word; split >> word;) words.push_back(word);
    try {
      if (words[0] == "device") {
        Expect(words, 2);
        Device device;
        device.number = device.port = static_cast<int>(Number(words[1]));
        devices.push_back(device);
      } else if (devices.empty()) {
        throw std::runtime_error("expected \"device N\" first");
      } else {
        ReadLine(line, words, &devices.back());
      }
    } catch (const std::exception& error) {
      throw std::runtime_error("line " + std::to_string(number) + ": " + error.what());
    }
  }
  return devices;
}

}  // namespace vantage::v4l2_shim
