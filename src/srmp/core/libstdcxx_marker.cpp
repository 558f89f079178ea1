// PyPI's libruckig.a was compiled with GCC 13 or later, whose <iostream> refers to this empty marker to require a
// libstdc++ that initialises std::cout itself. Older ones have no such symbol and initialise it wherever <iostream> is
// included. Weak and hidden, so that no other library sees it.
extern "C" [[gnu::weak, gnu::visibility("hidden")]] void _ZSt21ios_base_library_initv() {}
