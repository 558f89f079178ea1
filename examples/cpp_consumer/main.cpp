// Links against the installed library: which version is it, and where is the tool in the world?

#include <iostream>

#include "srmp/core/pose.hpp"
#include "srmp/core/version.hpp"

int main() {
  const srmp::Pose base = srmp::Pose::from_rpy({1.0, 0.0, 0.5}, {0.0, 0.0, 1.5707963267948966});
  const srmp::Pose tool = srmp::Pose::from_xyzw({0.2, 0.0, 0.1}, {0.0, 0.0, 0.0, 1.0});
  std::cout << "srmp " << srmp::version() << '\n';
  std::cout << "tool at " << (base * tool).p.transpose() << '\n';
}
