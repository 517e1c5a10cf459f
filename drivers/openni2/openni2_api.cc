#include "drivers/openni2/openni2_api.h"

#include <OpenNI.h>

#include <filesystem>
#include <utility>

#include "common/format.h"
#include "drivers/openni2/device_events.h"
#include "drivers/openni2/openni2_device.h"

namespace vantage {

class Openni2Api::Listener : public openni::OpenNI::DeviceConnectedListener,
                             public openni::OpenNI::DeviceDisconnectedListener,
                             public openni::OpenNI::DeviceStateChangedListener {
 public:
  void Add() {
    openni::OpenNI::addDeviceConnectedListener(this);
    openni::OpenNI::addDeviceDisconnectedListener(this);
    openni::OpenNI::addDeviceStateChangedListener(this);
  }
  void Remove() {
    openni::OpenNI::removeDeviceConnectedListener(this);
    openni::OpenNI::removeDeviceDisconnectedListener(this);
    openni::OpenNI::removeDeviceStateChangedListener(this);
  }

  void onDeviceConnected(const openni::DeviceInfo*) override { events.Connected(); }
  void onDeviceDisconnected(const openni::DeviceInfo* info) override {
    events.Disconnected(info->getUri());
  }
  void onDeviceStateChanged(const openni::DeviceInfo* info, openni::DeviceState state) override {
    if (state == openni::DEVICE_STATE_EOF) events.Ended(info->getUri());
  }

  DeviceEvents events;
};

Result<std::unique_ptr<Openni2Api>> Openni2Api::Create(RecordTarget record) {
  if (!record.file.empty()) {
    // OpenNI2 changes the working folder while it loads its drivers.
    record.file = std::filesystem::absolute(record.file);
    if (Result<void> valid = record.Validate(); !valid) return valid.error();
  }
  openni::OpenNI::setLogConsoleOutput(false);
  openni::OpenNI::setLogFileOutput(false);
  if (openni::OpenNI::initialize() != openni::STATUS_OK) {
    return Error{
        ErrorCode::kNotFound,
        Format("OpenNI2 does not start: %s; expected its drivers in OpenNI2/Drivers beside "
               "libOpenNI2.so.0; `apt-get install --reinstall libopenni2-0` brings them back",
               openni::OpenNI::getExtendedError())};
  }
  return std::unique_ptr<Openni2Api>(
      new Openni2Api(std::make_unique<Listener>(), std::move(record)));
}

Openni2Api::Openni2Api(std::unique_ptr<Listener> listener, RecordTarget record)
    : listener_(std::move(listener)), record_(std::move(record)) {
  listener_->Add();
}

Openni2Api::~Openni2Api() {
  listener_->Remove();
  if (!Openni2Device::HasLeftRecordings()) openni::OpenNI::shutdown();
}

std::vector<DeviceListing> Openni2Api::List() {
  openni::Array<openni::DeviceInfo> devices;
  openni::OpenNI::enumerateDevices(&devices);
  std::vector<DeviceListing> listing;
  for (int i = 0; i < devices.getSize(); ++i) {
    listing.push_back({devices[i].getUri(),
                       std::string(devices[i].getVendor()) + " " + devices[i].getName(),
                       {},
                       {}});
  }
  return listing;
}

Result<std::unique_ptr<CameraDevice>> Openni2Api::Open(const std::string& uri) {
  return Openni2Device::Open(uri, listener_->events, record_);
}

std::string Openni2Api::Describe() {
  std::string text;
  for (const DeviceListing& listing : List()) {
    text += Format("uri:%s  %s\n", listing.uri.c_str(), listing.name.c_str());
    const Result<std::unique_ptr<CameraDevice>> device = Open(listing.uri);
    if (!device) {
      text += "  " + device.error().message + "\n";
      continue;
    }
    const std::string serial = (*device)->serial();
    text += serial.empty() ? "  tells no serial\n" : "  serial:" + serial + "\n";
    text += static_cast<Openni2Device&>(**device).Describe();
  }
  return text.empty() ? "no OpenNI2 device; " + search_hint() + "\n" : text;
}

bool Openni2Api::WaitForDevice(std::chrono::milliseconds timeout) {
  return listener_->events.WaitForConnection(timeout);
}

}  // namespace vantage
