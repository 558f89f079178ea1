#include "library.hpp"

#include <dlfcn.h>

#include <stdexcept>

namespace srmp_moveit {

std::shared_ptr<Library> open_library() {
  void* handle = dlopen("libsrmp_moveit_session.so", RTLD_NOW | RTLD_LOCAL | RTLD_DEEPBIND);  // stays open
  void* make = handle ? dlsym(handle, "srmp_moveit_make_library") : nullptr;
  if (!make) throw std::runtime_error(std::string("the planning library cannot be opened: ") + dlerror());
  return std::shared_ptr<Library>(reinterpret_cast<Library* (*)()>(make)());
}

}  // namespace srmp_moveit
