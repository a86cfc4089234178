#include "grids/reader_limits.h"

#include <malloc.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>

#include "grids/vdb_reply.h"

namespace dapple::grids {
namespace {

/// What is said where memory ends, of which none is needed for saying it.
struct LastWords {
    Reply too_large;
    Reply damaged;
    std::uint64_t largest_piece = UINT64_MAX;  ///< larger ones no sound file asks for
};
LastWords last_words;

void prepare_last_words(const char* path, std::uint64_t most_bytes) {
    for (Reply* reply : {&last_words.too_large, &last_words.damaged}) {
        std::memcpy(reply->mark, kReplyMark, sizeof reply->mark);
    }
    last_words.too_large.outcome = Outcome::too_large;
    copy_text(last_words.too_large.message, ("takes more memory than the " + mebibytes(most_bytes) +
                                             " that are left, though it does not say so; it may be damaged")
                                                .c_str());
    last_words.damaged.outcome = Outcome::unreadable;
    copy_text(last_words.damaged.message, "asks for memory out of proportion to its size; it is damaged");
    struct stat state {};
    const std::uint64_t file = ::stat(path, &state) == 0 ? static_cast<std::uint64_t>(state.st_size) : 0;
    last_words.largest_piece = std::max<std::uint64_t>(4 * file, 16 << 20);
}

/// The address space that the process has now.
std::uint64_t address_space() {
    unsigned long pages = 0;
    if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
        if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
        std::fclose(file);
    }
    return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGE_SIZE));
}

}  // namespace

void write_all(const void* data, std::size_t size) {
    const char* next = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t written = ::write(kReplyFile, next, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) std::_Exit(1);
        next += written;
        size -= static_cast<std::size_t>(written);
    }
}

std::string mebibytes(std::uint64_t bytes) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f MiB", static_cast<double>(bytes) / (1 << 20));
    return text;
}

void confine_process() {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    ::mallopt(M_ARENA_MAX, 1);
    cpu_set_t this_one;
    CPU_ZERO(&this_one);
    CPU_SET(::sched_getcpu(), &this_one);
    ::sched_setaffinity(0, sizeof this_one, &this_one);
    ::setenv("OPENVDB_DISABLE_DELAYED_LOAD", "1", 1);
}

void limit_memory(const char* file, std::uint64_t most_bytes) {
    prepare_last_words(file, most_bytes);
#ifndef __SANITIZE_ADDRESS__  // whose shadow alone is larger than any limit
    const std::uint64_t most = address_space() + kSpareBytes + std::min(most_bytes, std::uint64_t{1} << 50);
    const rlimit limit{most, most};
    ::setrlimit(RLIMIT_AS, &limit);
#endif
}

// Throwing would not do: OpenVDB allocates where nothing may be thrown.
void run_out_of_memory(std::size_t piece) {
    const Reply& reply = piece > last_words.largest_piece ? last_words.damaged : last_words.too_large;
    write_all(&reply, sizeof reply);
    std::_Exit(0);
}

}  // namespace dapple::grids

void* operator new(std::size_t size) {
    void* const piece = std::malloc(std::max<std::size_t>(size, 1));
    if (piece == nullptr) dapple::grids::run_out_of_memory(size);
    return piece;
}

void operator delete(void* piece) noexcept {
    std::free(piece);
}

void operator delete(void* piece, std::size_t) noexcept {
    std::free(piece);
}
