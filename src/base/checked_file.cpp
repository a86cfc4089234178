#include "base/checked_file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/hash.h"

namespace dapple {
namespace {

std::string system_reason(int code) {
    return std::generic_category().message(code);
}

[[noreturn]] void fail_writing(const std::string& path, const std::string& what, int code) {
    throw Error(ExitCode::output_unwritable, path + ": " + what + ": " + system_reason(code));
}

[[noreturn]] void fail_reading(const std::string& path, const std::string& why) {
    throw Error(ExitCode::input_unreadable, path + ": cannot be read: " + why);
}

/// A file descriptor that is closed at the end of its scope.
class Descriptor {
public:
    explicit Descriptor(int number) : number_(number) {}
    ~Descriptor() {
        if (number_ >= 0) ::close(number_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int number() const { return number_; }
    /// Network file systems report a failed write only here.
    int close() { return ::close(std::exchange(number_, -1)); }

private:
    int number_;
};

/// Removes the file at the end of its scope, unless `keep` was called.
class Temporary {
public:
    explicit Temporary(std::string path) : path_(std::move(path)) {}
    ~Temporary() {
        if (!path_.empty()) ::unlink(path_.c_str());
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    void keep() { path_.clear(); }

private:
    std::string path_;
};

std::string host_name() {
    char name[256] = {};
    if (::gethostname(name, sizeof name - 1) != 0) return "localhost";
    return name;
}

std::filesystem::path folder_of(const std::filesystem::path& path) {
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

std::string temporary_name(const std::string& final_name) {
    std::string name = ".";
    name.append(final_name).append(".").append(host_name()).append(".");
    return name.append(std::to_string(::getpid())).append(".tmp");
}

std::vector<std::byte> read_descriptor(int descriptor, std::uint64_t size, const std::string& path) {
    std::vector<std::byte> bytes(size);
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = ::read(descriptor, bytes.data() + done, bytes.size() - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail_reading(path, system_reason(errno));
        if (got == 0) fail_reading(path, "it became shorter while it was read");
        done += static_cast<std::size_t>(got);
    }
    return bytes;
}

void sync_folder(const std::filesystem::path& folder, const std::string& path) {
    const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    // Some file systems cannot sync a folder and say EINVAL; theirs is then as safe as it gets.
    if (descriptor.number() < 0 || (::fsync(descriptor.number()) != 0 && errno != EINVAL)) {
        fail_writing(path, "its folder cannot be synced", errno);
    }
}

/// Process of a temporary's name `.NAME.<host>.<pid>.tmp` of this host, 0 where it is no such name.
pid_t process_of_temporary(std::string_view name, std::string_view host) {
    constexpr std::string_view suffix = ".tmp";
    if (!name.starts_with('.') || !name.ends_with(suffix)) return 0;
    name.remove_suffix(suffix.size());
    const std::size_t dot = name.rfind('.');
    const std::string_view digits = name.substr(dot + 1);
    pid_t process = 0;
    const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), process);
    if (fault != std::errc{} || end != digits.data() + digits.size() || process <= 0) return 0;
    const std::string_view before = name.substr(0, dot);
    const bool of_host = before.ends_with(host) && before.size() > host.size() + 1 &&
                         before[before.size() - host.size() - 1] == '.';
    return of_host ? process : 0;
}

}  // namespace

void write_all(int descriptor, std::span<const std::byte> bytes, const std::string& name) {
    // Linux writes at most 2 GiB a call; smaller pieces also notice a full disk before all is copied.
    constexpr std::size_t piece = std::size_t{1} << 26;
    while (!bytes.empty()) {
        const ssize_t count = ::write(descriptor, bytes.data(), std::min(bytes.size(), piece));
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) fail_writing(name, "cannot be written", errno);
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
}

WrittenFile write_file_atomically(const std::string& path, std::span<const std::byte> bytes,
                                  const VerifyBytes& verify) {
    const std::filesystem::path target(path);
    struct stat status {};
    if (::stat(path.c_str(), &status) == 0 && !S_ISREG(status.st_mode)) {
        throw Error(ExitCode::output_unwritable, path + ": is no regular file, so it is not replaced");
    }
    const std::string temporary_path = folder_of(target) / temporary_name(target.filename().string());

    Descriptor descriptor(
        ::open(temporary_path.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666));
    if (descriptor.number() < 0) fail_writing(path, "cannot be written", errno);
    Temporary temporary(temporary_path);

    write_all(descriptor.number(), bytes, path);
    if (::fsync(descriptor.number()) != 0) fail_writing(path, "cannot be synced", errno);
    // Once on disk, its pages may leave the cache, so that reading back asks the disk where the system allows
    // it.
    ::posix_fadvise(descriptor.number(), 0, 0, POSIX_FADV_DONTNEED);
    if (descriptor.close() != 0) fail_writing(path, "cannot be closed", errno);

    WrittenFile written{bytes.size(), content_hash(bytes.data(), bytes.size())};
    {
        std::vector<std::byte> read_back;
        try {
            read_back = read_whole_file(temporary_path, bytes.size());
        } catch (const Error& error) {
            throw Error(ExitCode::output_unwritable, path + ": written, but not read back: " + error.what());
        }
        if (read_back.size() != bytes.size() ||
            content_hash(read_back.data(), read_back.size()) != written.content_hash) {
            throw Error(ExitCode::output_unwritable, path + ": what was read back is not what was written");
        }
        if (verify) verify(read_back);
    }

    if (::rename(temporary_path.c_str(), path.c_str()) != 0) fail_writing(path, "cannot be renamed", errno);
    temporary.keep();
    sync_folder(folder_of(target), path);
    return written;
}

WrittenFile write_file_atomically(const std::string& path, std::string_view text) {
    return write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

std::size_t remove_stale_temporaries(const std::string& folder) {
    std::size_t removed = 0;
    std::error_code fault;
    const std::string host = host_name();
    for (std::filesystem::directory_iterator entry(folder, fault), end; !fault && entry != end;
         entry.increment(fault)) {
        const pid_t process = process_of_temporary(entry->path().filename().string(), host);
        if (process == 0 || ::kill(process, 0) == 0 || errno != ESRCH) continue;
        if (::unlink(entry->path().c_str()) == 0) ++removed;
    }
    return removed;
}

std::vector<std::byte> read_whole_file(const std::string& path, std::uint64_t most_bytes) {
    // Without O_NONBLOCK, opening a pipe that nobody writes to would wait for ever.
    const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
    if (descriptor.number() < 0) fail_reading(path, system_reason(errno));
    struct stat status {};
    if (::fstat(descriptor.number(), &status) != 0) fail_reading(path, system_reason(errno));
    if (!S_ISREG(status.st_mode)) fail_reading(path, "it is no regular file");
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > most_bytes) {
        fail_reading(path, "it has " + std::to_string(size) + " bytes, at most " +
                               std::to_string(most_bytes) + " are read");
    }
    return read_descriptor(descriptor.number(), size, path);
}

}  // namespace dapple
