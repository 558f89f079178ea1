#pragma once

#include <string>

namespace srmp {

/// What an option of another planner (MoveIt, OMPL, MPLib, cuRobo, …) is called here, or why there is none, as the end
/// of a sentence that begins with its name; "" for words that are not known. Upper case, '-', '_' and ' ' do not count.
std::string option_of_other_planner(const std::string& key);

/// The same for the id of a planner.
std::string planner_of_other_library(const std::string& id);

}  // namespace srmp
