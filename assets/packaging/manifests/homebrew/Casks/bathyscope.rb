cask "bathyscope" do
  version "@VERSION@"

  on_arm do
    url "@URL aarch64-macos.zip@"
    sha256 "@SHA256 aarch64-macos.zip@"
  end
  on_intel do
    url "@URL x86_64-macos.zip@"
    sha256 "@SHA256 x86_64-macos.zip@"
  end

  name "Bathyscope"
  desc "@SUMMARY@"
  homepage "@RELEASES@"

  depends_on macos: ">= :big_sur"

  app "Bathyscope.app"
  binary "#{appdir}/Bathyscope.app/Contents/MacOS/bathyscope"
end
