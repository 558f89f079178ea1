#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tinyxml2 {
class XMLDocument;
class XMLElement;
}  // namespace tinyxml2

namespace srmp::xml {

/// The content of a file. Throws FileError, whose text names the `kind` of file, such as "URDF".
std::string read_text(const std::string& path, const std::string& kind);

/// A parsed XML text. All functions throw FileError "<label>:<line>: <sentence>" for what is missing or wrong.
class Document {
 public:
  /// `root_tag` is the required outermost tag, and `label` names the text in messages. In a `strict` document, what
  /// warn() is told is thrown. Text that Xacro has yet to expand is refused.
  static Document read_file(const std::string& path, const std::string& kind, const char* root_tag);
  static Document parse(const std::string& text, const std::string& label, const char* root_tag, bool strict = false);
  ~Document();
  Document(Document&&) noexcept;

  const tinyxml2::XMLElement& root() const { return *root_; }
  const std::string& label() const { return label_; }

  /// Throws the FileError.
  [[noreturn]] void fail(int line, const std::string& sentence) const;
  [[noreturn]] void fail(const tinyxml2::XMLElement& at, const std::string& sentence) const;

  /// Keeps "<label>:<line>: <sentence>" as a warning: for a mistake that leaves the meaning of the document as it is. A
  /// sentence that comes again is counted. Throws it as fail() does when the document is strict.
  void warn(int line, const std::string& sentence);
  void warn(const tinyxml2::XMLElement& at, const std::string& sentence);
  /// The same, and never thrown: for what is no mistake in form.
  void note(const tinyxml2::XMLElement& at, const std::string& sentence);
  /// What warn() and note() were told.
  std::vector<std::string> warnings() const;

  /// The value of an attribute; nullopt when it is missing. required() throws when it is missing or empty.
  std::optional<std::string> attribute(const tinyxml2::XMLElement& element, const char* name) const;
  std::string required(const tinyxml2::XMLElement& element, const char* name) const;
  /// The numbers of an attribute; they must be finite.
  std::optional<double> number(const tinyxml2::XMLElement& element, const char* name) const;
  double required_number(const tinyxml2::XMLElement& element, const char* name) const;
  std::optional<Eigen::Vector3d> vector3(const tinyxml2::XMLElement& element, const char* name) const;
  /// All numbers in `text`, the value of attribute `name` of `element`.
  std::vector<double> numbers(const tinyxml2::XMLElement& element, const char* name, const std::string& text) const;

  /// Throws for child tags and attributes that are misspelt: their names are nearly those of known ones. Where the
  /// known attribute is there too, or the name is farther away, it is a warning. Names in `extensions`, and names that
  /// resemble no known one, belong to other tools and are accepted.
  void check_spelling(const tinyxml2::XMLElement& element, std::span<const std::string> tags,
                      std::span<const std::string> attributes, std::span<const std::string> extensions = {});

 private:
  struct Warning {
    int line{};
    std::string sentence;
    std::size_t repeats{};
  };

  Document();
  void add_warning(int line, const std::string& sentence);

  std::unique_ptr<tinyxml2::XMLDocument> document_;
  const tinyxml2::XMLElement* root_{};
  std::string label_;
  bool strict_{};
  std::vector<Warning> warnings_;
};

}  // namespace srmp::xml
