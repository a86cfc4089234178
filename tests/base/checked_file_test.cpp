#include "base/checked_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "base/error.h"
#include "base/hash.h"
#include "image/temporary_folder.h"

namespace dapple {
namespace {

using test::TemporaryFolder;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

std::vector<std::byte> sample_bytes(std::size_t size) {
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::byte>(hash_bits(1, 2, i, 3));
    return bytes;
}

/// The message of the error that writing must end with.
std::string failure_of_writing(const std::string& path, std::span<const std::byte> bytes) {
    try {
        write_file_atomically(path, bytes);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::output_unwritable);
        return error.what();
    }
    ADD_FAILURE() << path << " was written";
    return {};
}

std::string failure_of_reading(const std::string& path, std::uint64_t most = 1 << 20) {
    try {
        read_whole_file(path, most);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_unreadable);
        return error.what();
    }
    ADD_FAILURE() << path << " was read";
    return {};
}

TEST(CheckedFile, WritesWhatIsReadBack) {
    const TemporaryFolder folder;
    const auto bytes = sample_bytes(100'003);
    const WrittenFile written = write_file_atomically(folder / "a.bin", bytes);
    EXPECT_EQ(written.bytes, bytes.size());
    EXPECT_EQ(written.content_hash, content_hash(bytes.data(), bytes.size()));
    EXPECT_EQ(read_whole_file(folder / "a.bin"), bytes);
    EXPECT_THAT(folder.names(), ElementsAre("a.bin"));
}

TEST(CheckedFile, ReplacesAnOlderFileAndTakesAnEmptyOne) {
    const TemporaryFolder folder;
    write_file_atomically(folder / "a.txt", "old and long");
    write_file_atomically(folder / "a.txt", "new");
    EXPECT_EQ(read_whole_file(folder / "a.txt").size(), 3u);
    EXPECT_EQ(write_file_atomically(folder / "a.txt", "").bytes, 0u);
    EXPECT_THAT(read_whole_file(folder / "a.txt"), IsEmpty());
}

TEST(CheckedFile, TakesTheRightsOfTheUmask) {
    const TemporaryFolder folder;
    const mode_t before = ::umask(027);
    write_file_atomically(folder / "a", "x");
    ::umask(before);
    struct stat status {};
    ASSERT_EQ(::stat((folder / "a").c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777, 0640u);
}

TEST(CheckedFile, NamesPathAndReasonWhereTheFolderIsMissingOrNone) {
    const TemporaryFolder folder;
    const auto bytes = sample_bytes(10);
    EXPECT_THAT(failure_of_writing(folder / "none/a", bytes),
                AllOf(StartsWith(folder / "none/a"), HasSubstr("No such file")));
    write_file_atomically(folder / "file", "x");
    EXPECT_THAT(failure_of_writing(folder / "file/a", bytes), HasSubstr("Not a directory"));
}

TEST(CheckedFile, ReplacesNeitherFoldersNorDevices) {
    const TemporaryFolder folder;
    const auto bytes = sample_bytes(10);
    EXPECT_THAT(failure_of_writing(folder.path(), bytes), HasSubstr("no regular file"));
    EXPECT_THAT(failure_of_writing("/dev/full", bytes), HasSubstr("no regular file"));
    struct stat status {};
    ASSERT_EQ(::stat("/dev/full", &status), 0);
    EXPECT_TRUE(S_ISCHR(status.st_mode));
}

TEST(CheckedFile, RefusesAReadOnlyFolder) {
    const TemporaryFolder folder;
    ::chmod(folder.path().c_str(), 0555);
    // Root may write anywhere: be nobody for a moment.
    const bool is_root = ::geteuid() == 0;
    if (is_root) {
        ASSERT_EQ(::seteuid(65534), 0);
    }
    const std::string failure = failure_of_writing(folder / "a", sample_bytes(10));
    if (is_root) {
        ASSERT_EQ(::seteuid(0), 0);
    }
    EXPECT_THAT(failure, HasSubstr("Permission denied"));
    EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(CheckedFile, FullDeviceIsAnError) {
    const int full = ::open("/dev/full", O_WRONLY);
    ASSERT_GE(full, 0);
    try {
        write_all(full, sample_bytes(1000), "clip.mp4");
        ADD_FAILURE() << "a full device took the bytes";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::output_unwritable);
        EXPECT_THAT(error.what(), AllOf(StartsWith("clip.mp4"), HasSubstr("No space left")));
    }
    ::close(full);
}

// The limit makes the system write a part and only then fail, as a disk does that fills up.
TEST(CheckedFile, LimitInTheMiddleLosesNothing) {
    const TemporaryFolder folder;
    write_file_atomically(folder / "a", "before");
    const auto old_action = ::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    rlimit small = before;
    small.rlim_cur = 10'000;
    ::setrlimit(RLIMIT_FSIZE, &small);
    const std::string failure = failure_of_writing(folder / "a", sample_bytes(50'000));
    const auto fits = write_file_atomically(folder / "b", sample_bytes(10'000));
    ::setrlimit(RLIMIT_FSIZE, &before);
    ::signal(SIGXFSZ, old_action);
    EXPECT_THAT(failure, HasSubstr("File too large"));
    EXPECT_EQ(fits.bytes, 10'000u);
    EXPECT_THAT(folder.names(), ElementsAre("a", "b"));
    EXPECT_EQ(read_whole_file(folder / "a").size(), 6u);
}

// A pipe that is emptied slowly, and signals that break into the calls, make `write` return early.
TEST(CheckedFile, WritesAllInSpiteOfShortWrites) {
    const auto bytes = sample_bytes(3'000'000);
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    struct sigaction action {};
    struct sigaction before {};
    action.sa_handler = [](int) {};          // without SA_RESTART
    ::sigaction(SIGUSR1, &action, &before);  // before there is anybody who sends it
    const pid_t child = ::fork();
    if (child == 0) {
        ::close(ends[1]);
        std::vector<std::byte> got(bytes.size());
        std::size_t size = 0;
        for (ssize_t count = 1; count > 0; size += static_cast<std::size_t>(std::max<ssize_t>(count, 0))) {
            ::kill(::getppid(), SIGUSR1);
            count = ::read(ends[0], got.data() + size, got.size() - size);
        }
        ::_exit(size == bytes.size() && got == bytes ? 0 : 1);
    }
    ::close(ends[0]);
    write_all(ends[1], bytes, "pipe");
    ::close(ends[1]);
    int status = -1;
    while (::waitpid(child, &status, 0) < 0) {
    }
    ::sigaction(SIGUSR1, &before, nullptr);
    EXPECT_EQ(status, 0);
}

TEST(CheckedFile, KeepsTheOldFileWhereVerifyingFails) {
    const TemporaryFolder folder;
    write_file_atomically(folder / "a", "good");
    const auto reject = [](std::span<const std::byte>) {
        throw Error(ExitCode::output_unwritable, "damaged");
    };
    EXPECT_THROW(write_file_atomically(folder / "a", sample_bytes(9), reject), Error);
    EXPECT_THAT(folder.names(), ElementsAre("a"));
    EXPECT_EQ(read_whole_file(folder / "a").size(), 4u);
}

TEST(CheckedFile, VerifySeesTheBytes) {
    const TemporaryFolder folder;
    const auto bytes = sample_bytes(5000);
    std::vector<std::byte> seen;
    write_file_atomically(folder / "a", bytes,
                          [&](std::span<const std::byte> read) { seen.assign(read.begin(), read.end()); });
    EXPECT_EQ(seen, bytes);
}

TEST(CheckedFile, KillsLeaveAWholeFileOrNone) {
    const TemporaryFolder folder;
    const std::vector<std::vector<std::byte>> contents{sample_bytes(300'000), sample_bytes(700'000)};
    std::size_t leftovers = 0;
    for (unsigned kill = 0; kill < 20; ++kill) {
        const pid_t child = ::fork();
        if (child == 0) {
            for (std::size_t i = 0;; ++i) write_file_atomically(folder / "a", contents[i % 2]);
        }
        ::usleep(3'000 + hash_bits(0, 0, kill, 0) % 7'000);
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
        if (::access((folder / "a").c_str(), F_OK) == 0) {
            EXPECT_THAT(contents, testing::Contains(read_whole_file(folder / "a")));
        }
        leftovers += remove_stale_temporaries(folder.path());
    }
    EXPECT_THAT(folder.names(), ElementsAre("a"));
    EXPECT_GT(leftovers, 0u) << "no kill came in the middle of a write, so the test showed nothing";
}

TEST(StaleTemporaries, GoOnlyWhereTheirProcessIsGone) {
    const TemporaryFolder folder;
    const pid_t gone = ::fork();
    if (gone == 0) ::_exit(0);
    ::waitpid(gone, nullptr, 0);
    char host[256] = {};
    ::gethostname(host, sizeof host - 1);
    const std::string of_host = std::string(".a.exr.").append(host).append(".");
    const std::vector<std::string> kept{
        of_host + std::to_string(::getpid()) + ".tmp",        // this process
        of_host + std::to_string(::getppid()) + ".tmp",       // another that lives
        ".a.exr.elsewhere." + std::to_string(gone) + ".tmp",  // of another host
        of_host + "x1.tmp",
        of_host + "-1.tmp",
        of_host + "0.tmp",
        of_host.substr(1) + std::to_string(gone) + ".tmp",  // not hidden, so none of ours
        "a.exr",
    };
    for (const std::string& name : kept) std::ofstream(folder / name) << "x";
    std::ofstream(folder / (of_host + std::to_string(gone) + ".tmp")) << "x";
    EXPECT_EQ(remove_stale_temporaries(folder.path()), 1u);
    EXPECT_THAT(folder.names(), testing::UnorderedElementsAreArray(kept));
    EXPECT_EQ(remove_stale_temporaries(folder / "none"), 0u);
}

TEST(ReadWholeFile, NamesWhatIsWrong) {
    const TemporaryFolder folder;
    EXPECT_THAT(failure_of_reading(folder / "none"),
                AllOf(StartsWith(folder / "none"), HasSubstr("No such file")));
    EXPECT_THAT(failure_of_reading(folder.path()), HasSubstr("no regular file"));
    EXPECT_THAT(failure_of_reading("/dev/zero"), HasSubstr("no regular file"));
    ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
    EXPECT_THAT(failure_of_reading(folder / "pipe"), HasSubstr("no regular file"));
    write_file_atomically(folder / "a", "12345");
    EXPECT_THAT(failure_of_reading(folder / "a", 4), HasSubstr("at most 4"));
    EXPECT_EQ(read_whole_file(folder / "a", 5).size(), 5u);
}

}  // namespace
}  // namespace dapple
