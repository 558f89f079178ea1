#include "srmp/core/sha256.hpp"

#include <boost/test/unit_test.hpp>

using namespace srmp;

namespace {

std::string sha256(const std::string& text, std::size_t at_once = 1000) {
  Sha256 hash;
  for (std::size_t i = 0; i < text.size(); i += at_once) hash.add(text.data() + i, std::min(at_once, text.size() - i));
  return to_hex(hash.digest());
}

}  // namespace

BOOST_AUTO_TEST_CASE(sha256_gives_the_published_digests) {
  BOOST_TEST(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  BOOST_TEST(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  BOOST_TEST(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
             "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  BOOST_TEST(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

BOOST_AUTO_TEST_CASE(sha256_does_not_depend_on_how_the_data_are_divided) {
  const std::string text(200, 'x');
  for (const std::size_t at_once : {1, 3, 55, 56, 63, 64, 65, 128}) BOOST_TEST(sha256(text, at_once) == sha256(text));
}
