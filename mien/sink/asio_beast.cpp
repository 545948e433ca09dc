// What Asio and Beast have beside templates, compiled once for all rooms (CMakeLists.txt:
// *_SEPARATE_COMPILATION).
#include <boost/asio/impl/src.hpp>
#include <boost/beast/src.hpp>
