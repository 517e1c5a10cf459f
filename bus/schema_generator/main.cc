// Turns .lcm files into the table of bus/message_schema.h. Runs when the project is built.
//   schema_generator OUTPUT.cc FILE.lcm...

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

constexpr int kMaxCounts = 16;  // MessageSchema::kMaxCounts

struct Field {
  std::string type;
  std::string name;
  int64_t fixed_count = 1;
  std::string count_member;  // Empty: no variable dimension.
  bool is_array = false;
};

struct Struct {
  std::string name;
  std::vector<Field> fields;
};

struct Primitive {
  const char* kind;
  int64_t size;
  bool is_count;  // May be the size of an array.
};

const std::map<std::string, Primitive> kPrimitives = {{"byte", {"kByte", 1, false}},
                                                      {"boolean", {"kBool", 1, false}},
                                                      {"int8_t", {"kInt8", 1, true}},
                                                      {"int16_t", {"kInt16", 2, true}},
                                                      {"int32_t", {"kInt32", 4, true}},
                                                      {"int64_t", {"kInt64", 8, true}},
                                                      {"float", {"kFloat", 4, false}},
                                                      {"double", {"kDouble", 8, false}},
                                                      {"string", {"kString", 5, false}}};

std::vector<std::string> Tokenize(const std::string& text) {
  std::vector<std::string> tokens;
  for (size_t i = 0; i < text.size();) {
    const auto is_word = [&](size_t at) {
      return at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) != 0 ||
                                  text[at] == '_' || text[at] == '.');
    };
    if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size());
    } else if (text.compare(i, 2, "/*") == 0) {
      const size_t end = text.find("*/", i);
      if (end == std::string::npos) throw std::runtime_error("comment without an end");
      i = end + 2;
    } else if (is_word(i)) {
      const size_t begin = i;
      while (is_word(i)) ++i;
      tokens.push_back(text.substr(begin, i - begin));
    } else {
      if (std::isspace(static_cast<unsigned char>(text[i])) == 0) tokens.emplace_back(1, text[i]);
      ++i;
    }
  }
  return tokens;
}

class Parser {
 public:
  explicit Parser(std::vector<std::string> tokens) : tokens_(std::move(tokens)) {}

  std::vector<Struct> Parse() {
    std::vector<Struct> structs;
    while (next_ < tokens_.size()) {
      const std::string word = Take();
      if (word == "package") {
        Take();
        Expect(";");
      } else if (word == "struct") {
        structs.push_back(ParseStruct());
      } else {
        throw std::runtime_error("'" + word + "', expected package or struct");
      }
    }
    return structs;
  }

 private:
  std::string Take() {
    if (next_ >= tokens_.size()) throw std::runtime_error("the file ends too early");
    return tokens_[next_++];
  }

  void Expect(const std::string& token) {
    const std::string got = Take();
    if (got != token) throw std::runtime_error("'" + got + "', expected '" + token + "'");
  }

  [[nodiscard]] bool Sees(const std::string& token) const {
    return next_ < tokens_.size() && tokens_[next_] == token;
  }

  Struct ParseStruct() {
    Struct result{.name = Take(), .fields = {}};
    Expect("{");
    while (!Sees("}")) {
      if (Sees("const")) {
        while (Take() != ";") {
        }
      } else {
        ParseMembers(&result);
      }
    }
    Expect("}");
    if (Sees(";")) Take();
    return result;
  }

  // One declaration, perhaps of several members.
  void ParseMembers(Struct* result) {
    std::string type = Take();
    type = type.substr(type.rfind('.') + 1);  // All types are in one package.
    do {
      Field field{
          .type = type, .name = Take(), .fixed_count = 1, .count_member = {}, .is_array = false};
      while (Sees("[")) {
        Take();
        AddDimension(Take(), &field);
        Expect("]");
      }
      result->fields.push_back(field);
    } while (Sees(",") && Take() == ",");
    Expect(";");
  }

  static void AddDimension(const std::string& dimension, Field* field) {
    field->is_array = true;
    if (std::isdigit(static_cast<unsigned char>(dimension[0])) != 0) {
      field->fixed_count *= std::stoll(dimension);
      if (field->fixed_count < 1 || field->fixed_count > 1'000'000) {
        throw std::runtime_error(field->name + " has " + dimension + " elements");
      }
    } else if (field->count_member.empty() && field->fixed_count == 1) {
      field->count_member = dimension;
    } else {
      // The elements of a[n][m] can take no bytes at all while n says how much a decoder allocates.
      throw std::runtime_error(field->name + ": only the first dimension may be variable");
    }
  }

  std::vector<std::string> tokens_;
  size_t next_ = 0;
};

class Generator {
 public:
  void Add(const std::string& file) {
    std::ifstream stream(file);
    if (!stream) throw std::runtime_error("can't be read");
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    for (Struct& parsed : Parser(Tokenize(text)).Parse()) {
      const std::string name = parsed.name;
      if (!structs_.emplace(name, std::move(parsed)).second) {
        throw std::runtime_error(name + " is defined twice");
      }
    }
  }

  [[nodiscard]] std::string Generate() const {
    std::string text = "// Generated from lcmtypes/*.lcm.\n#include \"bus/message_schema.h\"\n\n";
    for (const auto& [name, unused] : structs_) text += "#include \"vantage/" + name + ".hpp\"\n";
    text += "\nnamespace vantage {\nnamespace {\n\nextern const MessageSchema kSchemas[" +
            std::to_string(structs_.size()) + "];\n\n";
    for (const auto& [name, type] : structs_) text += Fields(type);
    text += "const MessageSchema kSchemas[" + std::to_string(structs_.size()) + "] = {\n";
    for (const auto& [name, type] : structs_) {
      text += "    {\"" + name + "\", kFields_" + name + ", " + std::to_string(MinSize(name, {})) +
              ", &" + name + "::getHash},\n";
    }
    return text +
           "};\n\n}  // namespace\n\n"
           "std::span<const MessageSchema> AllSchemas() { return kSchemas; }\n\n"
           "}  // namespace vantage\n";
  }

 private:
  [[nodiscard]] const Struct& Find(const std::string& name) const {
    const auto found = structs_.find(name);
    if (found == structs_.end()) throw std::runtime_error("type " + name + " is unknown");
    return found->second;
  }

  // Bytes at least. `inside`: types that contain this one.
  [[nodiscard]] int64_t MinSize(const std::string& name, std::set<std::string> inside) const {
    if (!inside.insert(name).second) throw std::runtime_error(name + " contains itself");
    int64_t size = 0;
    for (const Field& field : Find(name).fields) {
      if (!field.count_member.empty()) continue;
      const auto primitive = kPrimitives.find(field.type);
      size += field.fixed_count * (primitive != kPrimitives.end() ? primitive->second.size
                                                                  : MinSize(field.type, inside));
    }
    if (size == 0) throw std::runtime_error(name + " may take no bytes at all");
    return size;
  }

  [[nodiscard]] std::string Fields(const Struct& type) const {
    const std::map<std::string, int> slots = CountSlots(type);
    std::string text = "const SchemaField kFields_" + type.name + "[] = {\n";
    for (const Field& field : type.fields) {
      const auto primitive = kPrimitives.find(field.type);
      const bool nested = primitive == kPrimitives.end();
      const auto into = slots.find(field.name);
      text += "    {\"" + field.name +
              "\", FieldKind::" + (nested ? "kNested" : primitive->second.kind) + ", " +
              (nested ? "&kSchemas[" + std::to_string(Index(field.type)) + "]" : "nullptr") + ", " +
              std::to_string(field.fixed_count) + ", " +
              std::to_string(field.count_member.empty() ? -1 : slots.at(field.count_member)) +
              ", " + std::to_string(into == slots.end() ? -1 : into->second) + ", " +
              (field.is_array ? "true" : "false") + "},\n";
    }
    return text + "};\n\n";
  }

  // Slots of the members that are sizes of arrays.
  static std::map<std::string, int> CountSlots(const Struct& type) {
    std::map<std::string, int> slots;
    std::set<std::string> integers;
    for (const Field& field : type.fields) {
      if (!field.count_member.empty()) {
        if (!integers.contains(field.count_member)) {
          throw std::runtime_error(type.name + "." + field.name + ": its size " +
                                   field.count_member + " is no integer member before it");
        }
        slots.emplace(field.count_member, static_cast<int>(slots.size()));
      }
      const auto primitive = kPrimitives.find(field.type);
      const bool is_single = field.fixed_count == 1 && field.count_member.empty();
      if (is_single && primitive != kPrimitives.end() && primitive->second.is_count) {
        integers.insert(field.name);
      }
    }
    if (slots.size() > kMaxCounts) throw std::runtime_error(type.name + " has too many arrays");
    return slots;
  }

  [[nodiscard]] size_t Index(const std::string& name) const {
    const auto found = structs_.find(name);
    if (found == structs_.end()) throw std::runtime_error("type " + name + " is unknown");
    return static_cast<size_t>(std::distance(structs_.begin(), found));
  }

  std::map<std::string, Struct> structs_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: schema_generator OUTPUT.cc FILE.lcm...\n");
    return 2;
  }
  std::string current = argv[1];
  try {
    Generator generator;
    for (int i = 2; i < argc; ++i) generator.Add(current = argv[i]);
    current = argv[1];
    const std::string text = generator.Generate();
    std::ofstream output(argv[1]);
    output << text;
    if (!output.flush()) throw std::runtime_error("can't be written");
  } catch (const std::exception& exception) {
    std::fprintf(stderr, "schema_generator: %s: %s\n", current.c_str(), exception.what());
    return 1;
  }
  return 0;
}
