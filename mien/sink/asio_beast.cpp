// The functions of Asio and Beast that are no templates, compiled once for all rooms (CMakeLists.txt: *_SEPARATE_COMPILATION).
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
