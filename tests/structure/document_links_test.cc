// Every link of a document to a file of the project leads somewhere.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

std::vector<std::string> BrokenLinks(const fs::path& document) {
  std::ifstream stream(document);
  std::ostringstream text;
  text << stream.rdbuf();
  static const std::regex kCode(R"(```[^]*?```|`[^`\n]*`)");
  const std::string content = std::regex_replace(text.str(), kCode, "");
  static const std::regex kLink(R"(\]\(([^)#\s]+)[^)]*\))");
  std::vector<std::string> broken;
  for (std::sregex_iterator it(content.begin(), content.end(), kLink), end; it != end; ++it) {
    const std::string target = (*it)[1];
    if (target.find("://") != std::string::npos) continue;
    if (!fs::exists(document.parent_path() / target)) broken.push_back(target);
  }
  return broken;
}

TEST(DocumentLinks, LeadSomewhere) {
  const fs::path root = VANTAGE_SOURCE_DIR;
  std::vector<fs::path> documents = {root / "README.md"};
  for (const fs::directory_entry& entry : fs::directory_iterator(root / "docs")) {
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  }
  ASSERT_GT(documents.size(), 5U);
  for (const fs::path& document : documents) {
    for (const std::string& target : BrokenLinks(document)) {
      ADD_FAILURE() << document.filename() << " links to " << target << ", which is not there";
    }
  }
}

TEST(DocumentLinks, ABrokenLinkIsFound) {
  const fs::path document = fs::temp_directory_path() / "vantage_document_links_test.md";
  std::ofstream(document) << "[x](no/such/file.md) [y](https://example.org/z) [z](.)";
  EXPECT_EQ(BrokenLinks(document), std::vector<std::string>{"no/such/file.md"});
  fs::remove(document);
}

}  // namespace
