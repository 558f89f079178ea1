#define BOOST_TEST_MODULE srmp
#include <boost/test/unit_test.hpp>
