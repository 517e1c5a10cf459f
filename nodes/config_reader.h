#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/so3.h"

namespace vantage {

/// Reads one TOML file strictly: every key must be asked for, every value in its range. Errors
/// gather; the first is returned by Finish(), naming file, line, key, value and bound.
///
///   ConfigReader reader = ...;
///   ConfigReader::Table fusion = reader.Root().Sub("fusion");
///   fusion.Read("sigma_deg", &sigma_deg, 0.1, 90.0);
///   if (Result<void> read = reader.Finish(); !read) return read.error();
class ConfigReader {
 public:
  class Table {
   public:
    /// Each leaves `*value` as it is (the default) when the key is absent.
    void Read(const std::string& key, double* value, double lowest, double highest);
    void Read(const std::string& key, int* value, int lowest, int highest);
    void Read(const std::string& key, int64_t* value, int64_t lowest, int64_t highest);
    void Read(const std::string& key, std::optional<double>* value, double lowest, double highest);
    void Read(const std::string& key, bool* value);
    void Read(const std::string& key, std::string* value);
    void Read(const std::string& key, std::vector<std::string>* value);
    /// Exactly `size` numbers in [lowest, highest].
    void ReadNumbers(const std::string& key,
                     size_t size,
                     double lowest,
                     double highest,
                     std::vector<double>* value);
    /// One of `allowed`.
    void ReadChoice(const std::string& key,
                    std::string* value,
                    const std::vector<std::string>& allowed);
    /// `position` (3 numbers, m) and `quaternion_wxyz` (4) or `rpy_deg` (3, intrinsic z-y-x) of
    /// this table.
    void ReadPose(Pose* value);
    /// A path, made absolute: relative ones start at the config file's folder.
    void ReadPath(const std::string& key, std::filesystem::path* value);
    /// The rule of ReadPath, for a path that is part of a text.
    [[nodiscard]] std::filesystem::path FromFolder(const std::filesystem::path& path) const;

    [[nodiscard]] bool Has(const std::string& key) const;
    /// True when the key was read, or its table taken, before.
    [[nodiscard]] bool WasAsked(const std::string& key) const;
    /// An error at Finish() when the key is absent.
    void Require(const std::string& key);
    /// A table of this table; an empty one when it is absent.
    Table Sub(const std::string& key);
    /// An array of tables ([[key]]); empty when it is absent.
    std::vector<Table> SubTables(const std::string& key);
    /// Keys of this table, in order: for tables whose keys are names that the user chose.
    [[nodiscard]] std::vector<std::string> Keys() const;
    /// Adds an error about a key, in words of the caller's, e.g. "expected a model of [models]".
    void Fail(const std::string& key, const std::string& expectation);
    /// Takes every key below as known. For tables that another process reads.
    void IgnoreAll();

   private:
    friend class ConfigReader;
    struct Node;
    explicit Table(std::shared_ptr<Node> node) : node_(std::move(node)) {}
    std::shared_ptr<Node> node_;
  };

  /// Errors: the file is absent, unreadable, larger than 1 MiB, or no TOML (with line and column).
  static Result<ConfigReader> Open(const std::filesystem::path& file);
  /// From a text, e.g. of a log's header; `name` stands for the file in messages.
  static Result<ConfigReader> Parse(const std::string& text, const std::string& name);

  Table Root();
  /// The first error met, else the first key that nobody asked for, else the first that is missing.
  Result<void> Finish();
  /// Every key that was asked for with the value in effect, the file's or the default, each as a
  /// line "table.key = value".
  [[nodiscard]] std::string Effective() const;
  /// The file's text.
  [[nodiscard]] const std::string& text() const;
  /// FNV-1a of the text, hexadecimal.
  [[nodiscard]] std::string Hash() const;

 private:
  struct Document;
  explicit ConfigReader(std::shared_ptr<Document> document) : document_(std::move(document)) {}
  std::shared_ptr<Document> document_;
};

}  // namespace vantage
