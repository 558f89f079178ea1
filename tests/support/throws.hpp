#pragma once

#include <boost/test/unit_test.hpp>
#include <string>

/// Runs `call`, expects an Exception whose text holds `fragment`.
template <class Exception, class Call>
void check_throws(Call&& call, const std::string& fragment) {
  try {
    call();
  } catch (const Exception& error) {
    BOOST_TEST(std::string(error.what()).find(fragment) != std::string::npos,
               "'" << error.what() << "' does not hold '" << fragment << "'");
    return;
  }
  BOOST_TEST(false, "no exception, expected one with '" << fragment << "'");
}
