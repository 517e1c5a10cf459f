#include "tools/support/pose_records.h"

#include <fstream>

#include "tests/tools/run_program.h"

namespace vantage {
namespace {

const std::string kLine = R"({"model":"cup","estimator":"ours","view":3,"is_peer":false,"ms":2.5,)"
                          R"("stages_ms":{"voting":2.0},"found":true,"within":true,"success":true,)"
                          R"("angle_deg":0.5,"distance_mm":0.25})";

class PoseRecords : public ScratchTest {
 protected:
  Result<void> Read(const std::string& text, std::vector<PoseRecord>* records) {
    std::ofstream(scratch() / "poses.jsonl") << text;
    return ReadPoseRecords(scratch() / "poses.jsonl", records);
  }
  // The line with `part` replaced, after a good line.
  void ExpectRefused(const std::string& part, const std::string& by) {
    std::string line = kLine;
    const size_t place = line.find(part);
    ASSERT_NE(place, std::string::npos) << part;
    line.replace(place, part.size(), by);
    std::vector<PoseRecord> records;
    const Result<void> read = Read(kLine + "\n" + line + "\n", &records);
    ASSERT_FALSE(read.ok()) << line;
    EXPECT_NE(read.error().message.find("poses.jsonl:2"), std::string::npos)
        << read.error().message;
  }
};

TEST_F(PoseRecords, AreAppended) {
  std::vector<PoseRecord> records(1);
  ASSERT_TRUE(Read(kLine + "\n" + kLine + "\n", &records).ok());
  ASSERT_EQ(records.size(), 3U);
  const PoseRecord& record = records[2];
  EXPECT_EQ(record.model, "cup");
  EXPECT_EQ(record.estimator, "ours");
  EXPECT_EQ(record.view, 3);
  EXPECT_FALSE(record.is_peer);
  EXPECT_EQ(record.ms, 2.5);
  EXPECT_EQ(record.stages_ms.at("voting"), 2.0);
  EXPECT_TRUE(record.is_within);
  EXPECT_TRUE(record.is_success);
  EXPECT_EQ(record.angle_deg, 0.5);
  EXPECT_EQ(record.distance_mm, 0.25);
}

TEST_F(PoseRecords, BadLinesAreErrorsThatNameThem) {
  ExpectRefused(R"("model":"cup",)", "");
  ExpectRefused(R"("cup")", "7");
  ExpectRefused(R"("view":3)", R"("view":"third")");
  ExpectRefused(R"("ms":2.5)", R"("ms":0)");
  ExpectRefused(R"("ms":2.5)", R"("ms":-1)");
  ExpectRefused(R"("ms":2.5)", R"("ms":null)");
  ExpectRefused(R"({"voting":2.0})", "[]");
  ExpectRefused(R"({"voting":2.0})", R"({"voting":"long"})");
  ExpectRefused(R"("success":true)", R"("success":false)");
  ExpectRefused(R"("angle_deg":0.5)", R"("angle_deg":{})");
  ExpectRefused("}", "");
  ExpectRefused("{", "[");
}

TEST_F(PoseRecords, AbsentFileIsAnError) {
  std::vector<PoseRecord> records;
  const Result<void> read = ReadPoseRecords(scratch() / "none.jsonl", &records);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace vantage
