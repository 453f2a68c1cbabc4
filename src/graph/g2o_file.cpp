// SPDX-License-Identifier: BSD-3-Clause
#include "kestrel_slam/graph/g2o_file.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string_view>

#include "kestrel_slam/graph/initial_poses.h"
#include "kestrel_slam/map/atomic_file.h"

namespace kestrel {
namespace {

using Id = std::int64_t;

[[noreturn]] void fail(const std::string& name, std::size_t line, const std::string& problem) {
  throw std::runtime_error(name + ", line " + std::to_string(line) + ": " + problem);
}

/// The beginning of a field, for messages, without characters that would disturb a console.
std::string quoted(std::string_view text) {
  constexpr std::size_t kShown = 30;
  std::string shown(text.substr(0, kShown));
  for (char& c : shown) c = c < ' ' || c > '~' ? '?' : c;
  return "'" + shown + (text.size() > kShown ? "...'" : "'");
}

/// The fields of one line.
class Fields {
 public:
  Fields(std::string_view line, const std::string& name, std::size_t number)
      : rest_(line), name_(name), number_(number) {}

  /// "" at the end of the line.
  std::string_view next() {
    constexpr const char* kSpace = " \t\r\f\v";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    const std::string_view field = rest_.substr(0, rest_.find_first_of(kSpace));
    rest_.remove_prefix(field.size());
    return field;
  }

  double number() {
    const std::string_view field = required();
    char* end = nullptr;  // white space or the end of the text follows the field
    const double value = std::strtod(field.data(), &end);
    if (end != field.data() + field.size() || !std::isfinite(value)) {
      failHere(quoted(field) + " is not a finite number");
    }
    return value;
  }

  Id id() { return idOf(required()); }

  Id idOf(std::string_view field) const {
    char* end = nullptr;
    errno = 0;
    const long long value = std::strtoll(field.data(), &end, 10);
    if (end != field.data() + field.size() || value < 0 || errno == ERANGE) {
      failHere(quoted(field) + " is not the id of a vertex (0, 1, 2, ...)");
    }
    return value;
  }

  void requireEnd() {
    const std::string_view field = next();
    if (!field.empty() && field.front() != '#') failHere(quoted(field) + " after the last number");
  }

  [[noreturn]] void failHere(const std::string& problem) const { fail(name_, number_, problem); }

 private:
  std::string_view required() {
    const std::string_view field = next();
    if (field.empty()) failHere("too few numbers");
    return field;
  }

  std::string_view rest_;
  const std::string& name_;
  std::size_t number_;
};

class Parser {
 public:
  explicit Parser(const std::string& name) : name_(name) {}

  G2oGraph parse(const std::string& text) {
    const std::string_view all(text);
    std::size_t number = 0;
    for (std::size_t begin = 0; begin < all.size();) {
      const std::size_t end = std::min(all.find('\n', begin), all.size());
      parseLine(all.substr(begin, end - begin), ++number);
      begin = end + 1;
    }
    if (edges_.empty() && vertices_.empty()) {
      throw std::runtime_error(name_ + ": the file has no VERTEX_SE2 and no EDGE_SE2");
    }
    return graph();
  }

 private:
  struct Vertex {
    Id id;
    PoseVertex vertex;
    std::size_t line;
  };
  /// What an edge or FIX names.
  struct Reference {
    Id from, to;
    std::size_t line;
  };

  void parseLine(std::string_view line, std::size_t number) {
    Fields fields(line, name_, number);
    const std::string_view tag = fields.next();
    if (tag.empty() || tag.front() == '#') return;
    if (tag == "EDGE_SE2") return addEdge(fields, number);
    if (tag == "VERTEX_SE2") return addVertex(fields, number);
    if (tag == "FIX") return addFixed(fields, number);
    fields.failHere(quoted(tag) + " is not supported, only VERTEX_SE2, EDGE_SE2 and FIX");
  }

  static Pose2 poseOf(Fields& fields) {
    const double x = fields.number(), y = fields.number(), yaw = fields.number();
    return {x, y, yaw};
  }

  void addVertex(Fields& fields, std::size_t line) {
    const Id id = fields.id();
    vertices_.push_back({id, {poseOf(fields)}, line});
    fields.requireEnd();
  }

  void addEdge(Fields& fields, std::size_t line) {
    const Id from = fields.id(), to = fields.id();
    PoseEdge edge;
    edge.measured = poseOf(fields);
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) {
        edge.information(row, column) = edge.information(column, row) = fields.number();
      }
    }
    fields.requireEnd();
    edge.to = from == to ? 0 : 1;
    const std::string problem = problemOf(edge, 2);
    if (!problem.empty()) fields.failHere("bad edge: " + problem);
    references_.push_back({from, to, line});
    edges_.push_back(edge);
  }

  void addFixed(Fields& fields, std::size_t line) {
    fixed_.push_back({fields.id(), 0, line});
    for (std::string_view next = fields.next(); !next.empty() && next.front() != '#';
         next = fields.next()) {
      fixed_.push_back({fields.idOf(next), 0, line});
    }
  }

  G2oGraph graph() {
    const bool placed = !vertices_.empty();
    if (!placed) nameVertices();
    sortVertices();
    G2oGraph result;
    for (const Vertex& vertex : vertices_) {
      result.graph.vertices.push_back(vertex.vertex);
      result.ids.push_back(vertex.id);
    }
    for (const Reference& fixed : fixed_) {
      result.graph.vertices[indexOf(fixed.from, fixed.line)].fixed = true;
    }
    result.graph.edges = connectedEdges();
    if (!placed) placeAlongEdges(result.graph);
    return result;
  }

  /// Of a file without VERTEX_SE2.
  void nameVertices() {
    for (const Reference& edge : references_) {
      vertices_.push_back({edge.from, {}, edge.line});
      vertices_.push_back({edge.to, {}, edge.line});
    }
    const auto byId = [](const Vertex& a, const Vertex& b) { return a.id < b.id; };
    const auto same = [](const Vertex& a, const Vertex& b) { return a.id == b.id; };
    std::sort(vertices_.begin(), vertices_.end(), byId);
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end(), same), vertices_.end());
  }

  void sortVertices() {
    std::stable_sort(vertices_.begin(), vertices_.end(),
                     [](const Vertex& a, const Vertex& b) { return a.id < b.id; });
    for (std::size_t i = 1; i < vertices_.size(); ++i) {
      if (vertices_[i].id != vertices_[i - 1].id) continue;
      fail(name_, vertices_[i].line,
           "vertex " + std::to_string(vertices_[i].id) + " is already in line " +
               std::to_string(vertices_[i - 1].line));
    }
  }

  std::size_t indexOf(Id id, std::size_t line) const {
    const auto found =
        std::lower_bound(vertices_.begin(), vertices_.end(), id,
                         [](const Vertex& vertex, Id wanted) { return vertex.id < wanted; });
    if (found == vertices_.end() || found->id != id) {
      fail(name_, line, "there is no VERTEX_SE2 " + std::to_string(id));
    }
    return static_cast<std::size_t>(found - vertices_.begin());
  }

  std::vector<PoseEdge> connectedEdges() {
    std::vector<bool> has_odometry(vertices_.size());  // to the next one
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      PoseEdge& edge = edges_[i];
      edge.from = indexOf(references_[i].from, references_[i].line);
      edge.to = indexOf(references_[i].to, references_[i].line);
      const std::size_t first = std::min(edge.from, edge.to);
      const bool odometry = std::max(edge.from, edge.to) == first + 1 && !has_odometry[first];
      edge.kind = odometry ? EdgeKind::kOdometry : EdgeKind::kLoop;
      if (odometry) has_odometry[first] = true;
    }
    return std::move(edges_);
  }

  const std::string& name_;
  std::vector<Vertex> vertices_;
  std::vector<PoseEdge> edges_;
  std::vector<Reference> references_, fixed_;  // `references_`: of the edges
};

/// The shortest of two precisions that gives the same double when it is read.
void append(std::string& text, double value) {
  char buffer[32];
  for (const int digits : {15, std::numeric_limits<double>::max_digits10}) {
    std::snprintf(buffer, sizeof buffer, " %.*g", digits, value);
    if (std::strtod(buffer, nullptr) == value) break;
  }
  text += buffer;
}

void append(std::string& text, const Pose2& pose) {
  append(text, pose.x);
  append(text, pose.y);
  append(text, pose.yaw);
}

}  // namespace

G2oGraph parseG2o(const std::string& text, const std::string& name) {
  return Parser(name).parse(text);
}

G2oGraph readG2o(const std::string& path) { return parseG2o(readFile(path), path); }

std::string g2oText(const G2oGraph& file) {
  const auto id = [&](std::size_t vertex) {
    return " " + std::to_string(file.ids.empty() ? static_cast<Id>(vertex) : file.ids[vertex]);
  };
  std::string vertices, fixed, edges;
  for (std::size_t i = 0; i < file.graph.vertices.size(); ++i) {
    const PoseVertex& vertex = file.graph.vertices[i];
    append(vertices += "VERTEX_SE2" + id(i), vertex.pose);
    vertices += '\n';
    if (vertex.fixed) fixed += "FIX" + id(i) + "\n";
  }
  for (const PoseEdge& edge : file.graph.edges) {
    append(edges += "EDGE_SE2" + id(edge.from) + id(edge.to), edge.measured);
    for (int row = 0; row < 3; ++row) {
      for (int column = row; column < 3; ++column) append(edges, edge.information(row, column));
    }
    edges += '\n';
  }
  return vertices + fixed + edges;
}

void writeG2o(const std::string& path, const G2oGraph& file) {
  writeFileAtomically(path, g2oText(file));
}

}  // namespace kestrel
