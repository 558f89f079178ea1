#include <algorithm>
#include <cctype>

#include "bind.hpp"

namespace srmp::python {

std::string brief(nb::handle value) {
  constexpr std::size_t max_size = 100;  // characters
  std::string text;
  for (const char c : nb::cast<std::string>(nb::repr(value))) {
    const bool space = std::isspace(static_cast<unsigned char>(c)) != 0;
    if (!space || text.empty() || text.back() != ' ') text += space ? ' ' : c;
  }
  if (text.size() <= max_size) return text;
  std::size_t end = max_size;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // within a character of UTF-8
  return text.substr(0, end) + " …";
}

Numbers to_numbers(nb::handle value, const std::string& what) {
  const auto refuse = [&](const std::string& kind) -> InvalidArgument {
    return InvalidArgument(what + " must be " + kind + ", but is " + brief(value));
  };
  if (value.is_none()) throw refuse("numbers");  // NumPy would make NaN of it
  try {
    const nb::module_ numpy = nb::module_::import_("numpy");
    const nb::object array = numpy.attr("asarray")(value);
    if (nb::cast<bool>(numpy.attr("iscomplexobj")(array))) throw refuse("real numbers");
    const nb::object numbers = numpy.attr("ascontiguousarray")(array, nb::arg("dtype") = "float64");
    return nb::cast<Numbers>(numbers);
  } catch (const nb::python_error& error) {
    if (!error.matches(PyExc_Exception)) throw;  // a Ctrl-C
    throw refuse("numbers");
  }
}

InvalidArgument wrong_shape(const std::string& what, const std::string& columns, const Numbers& numbers) {
  std::string shape;
  for (std::size_t i = 0; i < numbers.ndim(); ++i) shape += (i == 0 ? "" : ", ") + std::to_string(numbers.shape(i));
  if (numbers.ndim() == 1) shape += ",";
  return InvalidArgument(what + " must have the shape (n, " + columns + "), not (" + shape + ")");
}

Eigen::VectorXd ArrayLike::vector(const std::string& what) const {
  const auto numbers = to_numbers(value, what);
  if (numbers.ndim() != 1)
    throw InvalidArgument(what + " must be one row of numbers, but has " + std::to_string(numbers.ndim()) +
                          " dimensions");
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

Eigen::Vector3d ArrayLike::vector3(const std::string& what) const {
  const Eigen::VectorXd numbers = vector(what);
  if (numbers.size() != 3)
    throw InvalidArgument(what + " must be 3 numbers, x, y, z, but got " + std::to_string(numbers.size()));
  return numbers;
}

RowMatrix ArrayLike::rows(const std::string& what, Eigen::Index columns) const {
  const auto numbers = to_numbers(value, what);
  if (numbers.size() == 0) return RowMatrix(0, columns);
  if (numbers.ndim() != 2 || static_cast<Eigen::Index>(numbers.shape(1)) != columns)
    throw wrong_shape(what, std::to_string(columns), numbers);
  return Eigen::Map<const RowMatrix>(numbers.data(), static_cast<Eigen::Index>(numbers.shape(0)), columns);
}

NumpyArray to_numpy(const Eigen::Ref<const Eigen::VectorXd>& vector) {
  const NumpyArray row = to_numpy_rows({Eigen::VectorXd(vector)}, static_cast<std::size_t>(vector.size()));
  return nb::borrow<NumpyArray>(row.attr("reshape")(-1));
}

NumpyArray to_numpy_rows(const std::vector<Eigen::VectorXd>& rows, std::size_t columns) {
  RowMatrix matrix(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns));
  for (std::size_t i = 0; i < rows.size(); ++i) matrix.row(static_cast<Eigen::Index>(i)) = rows[i].transpose();
  return to_numpy_rows(std::move(matrix));
}

NumpyArray to_numpy_rows(RowMatrix rows) {
  auto* data = new RowMatrix(std::move(rows));
  const nb::capsule owner(data, [](void* p) noexcept { delete static_cast<RowMatrix*>(p); });
  const std::array<std::size_t, 2> shape{static_cast<std::size_t>(data->rows()),
                                         static_cast<std::size_t>(data->cols())};
  return nb::borrow<NumpyArray>(nb::cast(nb::ndarray<nb::numpy, double>(data->data(), 2, shape.data(), owner)));
}

OptionMap to_option_map(nb::handle dictionary) {
  if (nb::hasattr(dictionary, "to_dict")) return to_option_map(dictionary.attr("to_dict")());
  if (!nb::isinstance<nb::dict>(dictionary))
    throw InvalidArgument("planner options must be a dictionary or one of the option classes, but are " +
                          nb::cast<std::string>(nb::repr(dictionary)));
  OptionMap map;
  for (const auto [key, value] : nb::cast<nb::dict>(dictionary)) {
    const std::string name = nb::cast<std::string>(nb::str(key));
    if (nb::isinstance<nb::bool_>(value)) {
      map[name] = nb::cast<bool>(value);
    } else if (nb::isinstance<nb::str>(value)) {
      map[name] = nb::cast<std::string>(value);
    } else if (nb::isinstance<nb::list>(value) || nb::isinstance<nb::tuple>(value)) {
      map[name] = to_names(value, "option '" + name + "'");
    } else {
      double number{};
      if (!nb::try_cast<double>(value, number)) {
        if (!PyNumber_Check(value.ptr()) || PyComplex_Check(value.ptr()))
          throw InvalidArgument("option '" + name + "' is " + nb::cast<std::string>(nb::repr(value)) +
                                "; it must be a number, a string, True or False, or a list of strings");
        number = nb::cast<double>(nb::float_(value));
      }
      map[name] = number;
    }
  }
  return map;
}

nb::dict to_dict(const OptionMap& map) {
  nb::dict result;
  for (const auto& [key, value] : map)
    result[key.c_str()] = std::visit([](const auto& v) -> nb::object { return nb::cast(v); }, value);
  return result;
}

std::string to_path(nb::handle path) {
  std::string text;
  const bool is_path = nb::isinstance<nb::str>(path) || nb::hasattr(path, "__fspath__");
  if (!is_path)
    throw InvalidArgument("a path must be a str or an os.PathLike, but is " + nb::cast<std::string>(nb::repr(path)));
  if (!nb::try_cast(nb::module_::import_("os").attr("fspath")(path), text))
    throw InvalidArgument("a path must be text in characters that exist in UTF-8, but is " +
                          nb::cast<std::string>(nb::repr(path)));
  if (text.find('\0') != std::string::npos)
    throw InvalidArgument("a path cannot hold a null character, as " + nb::cast<std::string>(nb::repr(path)) + " does");
  return text;
}

std::vector<std::string> to_names(nb::handle names, const std::string& what) {
  if (nb::isinstance<nb::str>(names)) return {nb::cast<std::string>(names)};
  std::vector<std::string> result;
  if (!nb::try_cast(names, result))
    throw InvalidArgument(what + " must be text or a list of texts, but is " + brief(names));
  return result;
}

namespace {

/// One goal, but for numbers: those may be several configurations.
std::optional<Goal> to_goal(nb::handle value) {
  GoalConstraint constraint;
  Pose pose;
  if (nb::try_cast(value, constraint)) return Goal(constraint);
  if (nb::try_cast(value, pose)) return Goal(pose);
  if (nb::isinstance<nb::str>(value)) return Goal(nb::cast<std::string>(value));
  if (!nb::hasattr(value, "keys")) return std::nullopt;
  std::map<std::string, double> positions;
  const nb::object dictionary = nb::module_::import_("builtins").attr("dict")(value);
  bool has_pose = false;
  for (nb::handle each : dictionary.attr("values")()) has_pose = has_pose || nb::try_cast(each, pose);
  if (has_pose) return Goal(to_link_poses(dictionary));
  if (!nb::try_cast(dictionary, positions))
    throw InvalidArgument("a goal by joint names must be numbers by name, and one by link names Poses, but is " +
                          brief(value));
  return Goal(positions);
}

bool is_list(nb::handle value) { return nb::isinstance<nb::list>(value) || nb::isinstance<nb::tuple>(value); }

}  // namespace

std::map<std::string, Pose> to_link_poses(nb::handle value) {
  if (!nb::hasattr(value, "keys"))
    throw InvalidArgument("poses of links must be a dictionary by link name, but are " + brief(value));
  std::map<std::string, Pose> poses;
  for (nb::handle item : nb::module_::import_("builtins").attr("dict")(value).attr("items")()) {
    std::string link;
    if (!nb::try_cast(item[0], link)) throw InvalidArgument("a link's name is a string, but is " + brief(item[0]));
    if (!nb::try_cast(item[1], poses[link]))
      throw InvalidArgument("a goal gives either Poses of links or numbers of joints by name, not both; that of '" +
                            link + "' is " + brief(item[1]));
  }
  return poses;
}

std::vector<Goal> to_goals(nb::handle goal, const std::string& what) {
  if (const auto one = to_goal(goal)) return {*one};
  std::vector<Goal> goals;
  try {
    bool mixed = false;
    if (is_list(goal))
      for (nb::handle item : goal) mixed = mixed || to_goal(item);
    if (mixed) {
      for (nb::handle item : goal) {
        const auto one = to_goal(item);
        goals.push_back(one ? *one : Goal(ArrayLike{nb::borrow(item)}.vector(what)));
      }
      return goals;
    }
    const auto numbers = to_numbers(goal, what);
    if (numbers.size() > 0 && (numbers.ndim() == 1 || numbers.ndim() == 2)) {
      const auto columns = static_cast<Eigen::Index>(numbers.shape(numbers.ndim() - 1));
      for (std::size_t i = 0; i < numbers.size(); i += static_cast<std::size_t>(columns))
        goals.emplace_back(Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(numbers.data() + i, columns)));
      return goals;
    }
  } catch (const InvalidArgument&) {  // the sentence below says more
  }
  throw InvalidArgument(what +
                        " must be a GoalConstraint, a Pose, a configuration, positions by joint name, Poses by link "
                        "name, the name of a state, or a non-empty list of these, but is " +
                        brief(goal));
}

GoalConstraint constraint_without_scene(const std::string& robot, const Goal& goal,
                                        const std::optional<Eigen::VectorXd>&) {
  if (const auto* constraint = std::get_if<GoalConstraint>(&goal)) return *constraint;
  if (const auto* pose = std::get_if<Pose>(&goal)) return GoalConstraint::pose(*pose);
  if (const auto* q = std::get_if<Eigen::VectorXd>(&goal)) return GoalConstraint::joints(*q);
  if (const auto* poses = std::get_if<std::map<std::string, Pose>>(&goal)) return GoalConstraint::poses(*poses);
  throw InvalidArgument("a request knows no joints and states of '" + robot + "': give it PlannerInterface.goal('" +
                        robot + "', …) instead of their names");
}

std::map<std::string, nb::object> to_map(nb::handle mapping, const std::string& what) {
  if (!nb::hasattr(mapping, "keys") || !nb::hasattr(mapping, "__getitem__"))
    throw InvalidArgument(what + " must be a dictionary by robot name, but are " + brief(mapping));
  std::map<std::string, nb::object> map;
  for (nb::handle key : mapping.attr("keys")()) {
    if (!nb::isinstance<nb::str>(key))
      throw InvalidArgument(what + " must be by robot name, which is a string, but one is by " + brief(key));
    map[nb::cast<std::string>(key)] = mapping[key];
  }
  return map;
}

std::map<std::string, Trajectory> to_trajectories(nb::handle mapping, const std::string& what) {
  std::map<std::string, Trajectory> trajectories;
  for (const auto& [name, value] : to_map(mapping, what))
    if (!nb::try_cast(value, trajectories[name]))
      throw InvalidArgument(what + " must be Trajectory objects by robot name, but that of '" + name + "' is " +
                            brief(value));
  return trajectories;
}

std::map<std::string, std::vector<PathConstraint>> to_path_constraints(nb::handle mapping) {
  std::map<std::string, std::vector<PathConstraint>> constraints;
  if (mapping.is_none()) return constraints;
  for (const auto& [name, value] : to_map(mapping, "constraints"))
    if (!nb::try_cast(value, constraints[name]))
      throw InvalidArgument("constraints must be lists of PathConstraint objects by robot name, but those of '" + name +
                            "' are " + brief(value));
  return constraints;
}

MultiPlanRequest to_multi_request(nb::handle starts, nb::handle goals, nb::handle obstacles, nb::handle constraints,
                                  const ToConstraint& to_constraint) {
  MultiPlanRequest request;
  for (const auto& [name, start] : to_map(starts, "starts"))
    request.starts[name] = ArrayLike{start}.vector("start of '" + name + "'");
  for (const auto& [name, goal] : to_map(goals, "goals")) {
    const std::vector<Goal> forms = to_goals(goal, "the goal of '" + name + "'");
    if (forms.size() != 1)
      throw InvalidArgument("the goal of '" + name + "' must be one; a GoalConstraint can have several targets");
    const auto start = request.starts.find(name);
    const bool starts_here = start != request.starts.end();
    request.goals.emplace(name,
                          to_constraint(name, forms[0], starts_here ? std::optional(start->second) : std::nullopt));
  }
  if (!obstacles.is_none()) request.obstacles = to_trajectories(obstacles, "obstacles");
  request.constraints = to_path_constraints(constraints);
  return request;
}

}  // namespace srmp::python
