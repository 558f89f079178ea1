#pragma once

#include <functional>
#include <string>
#include <vector>

#include "srmp/io/moveit.hpp"

namespace srmp {

/// The scenes, each a difference, that io::apply must be given in this order so that a scene which `held` made becomes
/// one that `target` makes; none where they agree. Both are whole scenes. The positions of the `planned` joints count
/// only for what is placed in a frame that `moves` with them, because they are where a plan starts; what the robot
/// state says of other joints does.
std::vector<io::SceneFile> scene_difference(const io::SceneFile& held, const io::SceneFile& target,
                                            const std::vector<std::string>& planned,
                                            const std::function<bool(const std::string& frame)>& moves);

}  // namespace srmp
