# Installs what a Windows machine lacks to build raindrops, and builds it as target\release\raindrops.exe. What is missing comes
# by winget: Rust, the C++ build tools of Visual Studio for their linker, and the Vulkan SDK for its shader compiler's library.
# A driver for Vulkan is the machine's own. Not run on Windows yet: see docs/windows.md.
#
#   powershell -ExecutionPolicy Bypass -File scripts\setup.ps1
$ErrorActionPreference = 'Stop'
Set-Location (Join-Path $PSScriptRoot '..')

function Fail($words) {
    Write-Host "setup: $words"
    exit 2
}

function Install($id, $more) {
    if (-not (Get-Command winget -ErrorAction SilentlyContinue)) {
        Fail "there is no winget; get 'App Installer' of the Microsoft Store, or install $id by hand, and run this again"
    }
    Write-Host "setup: installing $id"
    & winget install --exact --id $id --silent --accept-source-agreements --accept-package-agreements @more
    if ($LASTEXITCODE -ne 0) { Fail "winget could not install $id; install it by hand, and run this again" }
}

$env:Path += ";$env:USERPROFILE\.cargo\bin"
if (-not (Get-Command cargo -ErrorAction SilentlyContinue)) { Install 'Rustlang.Rustup' @() }

$vswhere = "${env:ProgramFiles(x86)}\Microsoft Visual Studio\Installer\vswhere.exe"
$tools = 'Microsoft.VisualStudio.Component.VC.Tools.x86.x64'
if (-not (Test-Path $vswhere) -or -not (& $vswhere -products * -requires $tools -property installationPath)) {
    $load = '--quiet --wait --add Microsoft.VisualStudio.Workload.VCTools --includeRecommended'
    Install 'Microsoft.VisualStudio.2022.BuildTools' @('--override', $load)
}

# .cargo/config.toml points the shaderc crate at .setup/shaderc, as on Linux.
$library = '.setup\shaderc\shaderc_combined.lib'
if (-not (Test-Path $library)) {
    # An installation of just now is not in the environment of this process.
    $sdk = $env:VULKAN_SDK
    if (-not $sdk) { $sdk = [Environment]::GetEnvironmentVariable('VULKAN_SDK', 'Machine') }
    if (-not $sdk) {
        Install 'KhronosGroup.VulkanSDK' @()
        $sdk = [Environment]::GetEnvironmentVariable('VULKAN_SDK', 'Machine')
    }
    if (-not $sdk -or -not (Test-Path "$sdk\Lib\shaderc_combined.lib")) {
        Fail "the Vulkan SDK ('$sdk') has no Lib\shaderc_combined.lib"
    }
    New-Item -ItemType Directory -Force '.setup\shaderc' | Out-Null
    Copy-Item "$sdk\Lib\shaderc_combined.lib" $library
}

& cargo build --release --locked
if ($LASTEXITCODE -ne 0) { Fail 'the program does not build' }
Write-Host 'setup: target\release\raindrops.exe'
