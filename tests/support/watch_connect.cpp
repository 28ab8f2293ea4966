// Stands before libc's own connect, socket and getaddrinfo, in a program that is linked with it or told to
// load it (LD_PRELOAD): whoever turns to a network is written down, a line each, in the file that
// LIKENESS_CALLS names, and goes on as if nobody had watched.
#include <dlfcn.h>
#include <fcntl.h>
#include <netdb.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

namespace {

void write_down(const char* what) {
  const char* file = ::getenv("LIKENESS_CALLS");
  if (!file) return;
  const int fd = ::open(file, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (fd < 0) return;
  if (::write(fd, what, ::strlen(what)) < 0 || ::write(fd, "\n", 1) < 0) {
  }
  ::close(fd);
}

bool is_network(int family) { return family == AF_INET || family == AF_INET6; }

template <class Call>
Call libc_own(const char* name) {
  return reinterpret_cast<Call>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

int connect(int fd, const sockaddr* address, socklen_t length) {
  if (address && is_network(address->sa_family)) write_down("connect");
  return libc_own<int (*)(int, const sockaddr*, socklen_t)>("connect")(fd, address, length);
}

int socket(int family, int type, int protocol) noexcept {
  if (is_network(family)) write_down("socket");
  return libc_own<int (*)(int, int, int)>("socket")(family, type, protocol);
}

int getaddrinfo(const char* node, const char* service, const addrinfo* hints, addrinfo** found) {
  if (node) write_down(node);
  return libc_own<int (*)(const char*, const char*, const addrinfo*, addrinfo**)>("getaddrinfo")(
      node, service, hints, found);
}

}  // extern "C"
