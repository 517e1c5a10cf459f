#include "nodes/config_override.h"

#include <gtest/gtest.h>

#include "nodes/config_reader.h"

namespace vantage {
namespace {

std::string Literal(const std::string& setting) {
  const Result<ConfigOverride> parsed = ParseConfigOverride(setting);
  return parsed ? parsed->literal : "error: " + parsed.error().message;
}

std::string With(const std::string& text, const std::vector<std::string>& settings) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& setting : settings) {
    const Result<ConfigOverride> parsed = ParseConfigOverride(setting);
    if (!parsed) return "error: " + parsed.error().message;
    overrides.push_back(*parsed);
  }
  const Result<std::string> result = OverriddenConfigText(text, overrides);
  return result ? *result : "error: " + result.error().message;
}

TEST(ConfigOverride, ValuesAreTomlAndPlainWordsAreTexts) {
  EXPECT_EQ(Literal("fusion.sigma_deg=6"), "6");
  EXPECT_EQ(Literal(" fusion.sigma_deg = 6.5 "), "6.5");
  EXPECT_EQ(Literal("a.b=true"), "true");
  EXPECT_EQ(Literal("a.b=mug"), "'mug'");
  EXPECT_EQ(Literal("a.b=\"6\""), "\"6\"");
  EXPECT_EQ(Literal("a.b='mug'"), "'mug'");
  EXPECT_EQ(Literal("a.b=/a/b=c d.toml"), "'/a/b=c d.toml'");
  EXPECT_EQ(Literal("a.b=4,5"), "'4,5'");
  EXPECT_EQ(Literal("a.b=[1, 2]"), "[1, 2]");
  EXPECT_EQ(Literal("a.b=[mug,filter]"), "['mug', 'filter']");
  EXPECT_EQ(Literal("a.b=[mug, 'filter', 3]"), "['mug', 'filter', 3]");
  EXPECT_EQ(Literal("a.b=[]"), "[]");
  EXPECT_EQ(Literal("a.b={c = 3}"), "{c = 3}");
}

TEST(ConfigOverride, MalformedSettingsAreRefused) {
  for (const char* setting : {"",
                              "=",
                              "=5",
                              "fusion.sigma_deg",
                              "fusion.sigma_deg=",
                              "fusion.sigma_deg= ",
                              ".a=5",
                              "a.=5",
                              "a..b=5",
                              "a b=5",
                              "a[x]=5",
                              "a[-1]=5",
                              "a[99999999999999999999]=5",
                              "a=\"open",
                              "a=[1, 2",
                              "a=[1, \"2]",
                              "a={b = }",
                              "a=[1]\nb=5",
                              "a=\"x\" # y"}) {
    EXPECT_EQ(Literal(setting).substr(0, 6), "error:") << setting << ": " << Literal(setting);
  }
  // What could end the line stays a text.
  EXPECT_EQ(With("", {"a=x\nb=5"}), "a = '''x\nb=5'''\n");
}

TEST(ConfigOverride, ReplacesInPlaceAndKeepsComments) {
  const std::string text =
      "# set-up äöü\n[fusion]\nname = 'ö' # n\nsigma_deg = 4.0   # degrees\n\n[planner]\n"
      "target_m = [0.0,\n  0.0]  # two lines\n";
  EXPECT_EQ(With(text, {"fusion.sigma_deg=6", "planner.target_m=[1,2]", "fusion.name=mug"}),
            "# set-up äöü\n[fusion]\nname = 'mug' # n\nsigma_deg = 6   # degrees\n\n[planner]\n"
            "target_m = [1,2]  # two lines\n");
  EXPECT_EQ(With(text, {"fusion.sigma_deg=6", "fusion.sigma_deg=7"}),
            With(text, {"fusion.sigma_deg=7"}));
  EXPECT_EQ(With(text, {}), text);
}

TEST(ConfigOverride, AddsKeysAndTables) {
  EXPECT_EQ(With("[a]  # here\nx = 1\n[b]\ny = 2", {"a.z=3"}),
            "[a]  # here\nz = 3\nx = 1\n[b]\ny = 2\n");
  EXPECT_EQ(With("[a]\nx = 1", {"b.c.d=3"}), "[a]\nx = 1\n\n[b.c]\nd = 3\n");
  EXPECT_EQ(With("[a.b]\nx = 1\n", {"a.y=3"}), "[a.b]\nx = 1\n\n[a]\ny = 3\n");
  EXPECT_EQ(With("", {"a.b=3", "a.c=4"}), "\n[a]\nc = 4\nb = 3\n");
  EXPECT_EQ(With("[a]\n", {"x=3"}), "x = 3\n[a]\n");
}

TEST(ConfigOverride, ReachesElementsOfLists) {
  const std::string text = "[[sim.object]]\nmodel = 'a'\n[[sim.object]]\nmodel = 'b'\n";
  EXPECT_EQ(With(text, {"sim.object[1].model=c", "sim.object[0].x=1"}),
            "[[sim.object]]\nx = 1\nmodel = 'a'\n[[sim.object]]\nmodel = 'c'\n");
  EXPECT_EQ(With("[a]\nuse = [1, 2, 3]\n", {"a.use[1]=9"}), "[a]\nuse = [1, 9, 3]\n");
  EXPECT_EQ(With(text, {"sim.object[2].model=c"}),
            "error: sim.object[2].model: object has 2 elements");
  EXPECT_EQ(With(text, {"sim.objects[0].model=c"}),
            "error: sim.objects[0].model: objects has 0 elements");
  EXPECT_EQ(With(text, {"new.list[0].model=c"}), "error: new.list[0].model: list has 0 elements");
}

TEST(ConfigOverride, ValuesAreNoTables) {
  EXPECT_EQ(With("[a]\nx = 1\n", {"a.x.y=3"}), "error: a.x.y: x is no table");
  EXPECT_EQ(With("[[a]]\nx = 1\n", {"a.x=3"}), "error: a.x: a is no table");
  EXPECT_EQ(With("a = \n", {}), "error: the configuration is no valid TOML");
}

// However a file is written, its reader sees what was set and all the rest as before.
TEST(ConfigOverride, ReadersSeeWhatWasSetInAnyStyle) {
  for (const char* text : {"[a]\nx = 1\n\n[a.b]\ny = 2\n",
                           "a.x = 1\na.b.y = 2\n",
                           "a = { x = 1, b = { y = 2 } }\n",
                           "[a]\nx = 1\nb.y = 2",
                           "[a]\r\nx = 1\r\n[a.b]\r\ny = 2\r\n",
                           "[a.b]\ny = 2\n[a]\nx = 1\n",
                           "[a]\nx = 1\nb = { y = 2 } # c"}) {
    for (const char* setting : {"a.b.y=7", "a.b.z=7", "a.w=7", "a.c.v=7"}) {
      const std::string edited = With(text, {setting});
      Result<ConfigReader> reader = ConfigReader::Parse(edited, "x.toml");
      ASSERT_TRUE(reader.ok()) << edited;
      ConfigReader::Table a = reader->Root().Sub("a");
      int x = 0;
      int w = 0;
      a.Read("x", &x, 0, 9);
      a.Read("w", &w, 0, 9);
      int y = 0;
      int z = 0;
      int v = 0;
      ConfigReader::Table b = a.Sub("b");
      b.Read("y", &y, 0, 9);
      b.Read("z", &z, 0, 9);
      a.Sub("c").Read("v", &v, 0, 9);
      EXPECT_TRUE(reader->Finish().ok()) << edited;
      const std::string key = setting;
      EXPECT_EQ(x, 1) << edited;
      EXPECT_EQ(y, key == "a.b.y=7" ? 7 : 2) << edited;
      EXPECT_EQ(z, key == "a.b.z=7" ? 7 : 0) << edited;
      EXPECT_EQ(w, key == "a.w=7" ? 7 : 0) << edited;
      EXPECT_EQ(v, key == "a.c.v=7" ? 7 : 0) << edited;
    }
  }
}

}  // namespace
}  // namespace vantage
