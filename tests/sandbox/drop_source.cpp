#include "tests/sandbox/drop_source.h"

#include <stdexcept>

#ifdef GELENK_X11
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <poll.h>

#include <array>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string_view>
#endif

namespace gelenk::testing {

#ifndef GELENK_X11

bool canDropFiles() { return false; }
void dropFiles(const std::string&, const std::vector<std::string>&, int, int, int) {
  throw std::runtime_error("built without X11");
}

#else

namespace {

std::string uriList(const std::vector<std::string>& paths) {
  std::string list;
  for (const std::string& path : paths) {
    list += "file://";
    for (const unsigned char c : path) {
      char escaped[4];
      std::snprintf(escaped, sizeof escaped, "%%%02X", c);
      const bool plain = std::isalnum(c) || std::string_view("/.-_").find(c) != std::string_view::npos;
      list += plain ? std::string(1, static_cast<char>(c)) : escaped;
    }
    list += "\r\n";
  }
  return list;
}

/// The source's window and what it says to the target's.
class DropSource {
 public:
  DropSource(const std::string& name, int patienceSeconds)
      : display_(XOpenDisplay(name.c_str()), XCloseDisplay),
        end_(std::chrono::steady_clock::now() + std::chrono::seconds(patienceSeconds)) {
    if (!display_) throw std::runtime_error("no X11 display " + name);
    own_ = XCreateSimpleWindow(display(), root(), 0, 0, 1, 1, 0, 0, 0);
  }

  void drop(const std::string& uris, int x, int y) {
    const long me = static_cast<long>(own_), place = static_cast<long>(x) << 16 | y;
    const long uriType = static_cast<long>(atom("text/uri-list"));
    target_ = windowAt(x, y);
    XSetSelectionOwner(display(), atom("XdndSelection"), own_, CurrentTime);
    say("XdndEnter", {me, 5L << 24, uriType, 0, 0});
    say("XdndPosition", {me, 0, place, CurrentTime, static_cast<long>(atom("XdndActionCopy"))});
    if (!(waitFor("XdndStatus", uris).data.l[1] & 1)) throw std::runtime_error("the window takes no drop");
    say("XdndDrop", {me, 0, CurrentTime, 0, 0});
    waitFor("XdndFinished", uris);
  }

 private:
  Display* display() { return display_.get(); }
  Window root() { return DefaultRootWindow(display()); }
  Atom atom(const char* name) { return XInternAtom(display(), name, False); }

  bool takesDrops(Window window) {
    Atom type = None;
    int format = 0;
    unsigned long count = 0, left = 0;
    unsigned char* value = nullptr;
    XGetWindowProperty(display(), window, atom("XdndAware"), 0, 1, False, AnyPropertyType, &type, &format,
                       &count, &left, &value);
    if (value) XFree(value);
    return type != None;
  }

  Window windowAt(int x, int y) {
    Window parent = None, above = None, *children = nullptr;
    unsigned int count = 0;
    XQueryTree(display(), root(), &above, &parent, &children, &count);
    Window found = None;
    for (unsigned int i = 0; i < count; ++i) {
      XWindowAttributes a;
      if (XGetWindowAttributes(display(), children[i], &a) && a.map_state == IsViewable && x >= a.x &&
          y >= a.y && x < a.x + a.width && y < a.y + a.height && takesDrops(children[i]))
        found = children[i];
    }
    if (children) XFree(children);
    if (found == None) throw std::runtime_error("no window there that takes drops");
    return found;
  }

  void say(const char* what, const std::array<long, 5>& words) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = target_;
    event.xclient.message_type = atom(what);
    event.xclient.format = 32;
    for (std::size_t k = 0; k < words.size(); ++k) event.xclient.data.l[k] = words[k];
    XSendEvent(display(), target_, False, NoEventMask, &event);
    XFlush(display());
  }

  /// The target's message; hands it the files meanwhile, where it asks for them.
  XClientMessageEvent waitFor(const char* what, const std::string& uris) {
    while (std::chrono::steady_clock::now() < end_) {
      pollfd connection{ConnectionNumber(display()), POLLIN, 0};
      if (XPending(display()) == 0) poll(&connection, 1, 50);
      while (XPending(display()) > 0) {
        XEvent event;
        XNextEvent(display(), &event);
        if (event.type == ClientMessage && event.xclient.message_type == atom(what)) return event.xclient;
        if (event.type == SelectionRequest) handOver(event.xselectionrequest, uris);
      }
    }
    throw std::runtime_error(std::string("the window did not answer with ") + what);
  }

  void handOver(const XSelectionRequestEvent& request, const std::string& uris) {
    XChangeProperty(display(), request.requestor, request.property, request.target, 8, PropModeReplace,
                    reinterpret_cast<const unsigned char*>(uris.data()), static_cast<int>(uris.size()));
    XEvent event{};
    event.xselection = {.type = SelectionNotify,
                        .serial = 0,
                        .send_event = True,
                        .display = display(),
                        .requestor = request.requestor,
                        .selection = request.selection,
                        .target = request.target,
                        .property = request.property,
                        .time = request.time};
    XSendEvent(display(), request.requestor, False, NoEventMask, &event);
    XFlush(display());
  }

  std::unique_ptr<Display, int (*)(Display*)> display_;
  std::chrono::steady_clock::time_point end_;
  Window own_ = None, target_ = None;
};

}  // namespace

bool canDropFiles() { return true; }

void dropFiles(const std::string& display, const std::vector<std::string>& paths, int x, int y,
               int patienceSeconds) {
  DropSource(display, patienceSeconds).drop(uriList(paths), x, y);
}

#endif

}  // namespace gelenk::testing
