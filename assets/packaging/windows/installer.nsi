; The installer of Bathyscope for one user of Windows, who needs no rights of an administrator for it. `build` beside it has makensis compile it:
; VERSION, NUMBERS (1.2.3.0), STAGE (the folder of the archive) and OUT come from there.

Unicode true
Target amd64-unicode
SetCompressor /SOLID lzma
ManifestDPIAware true
RequestExecutionLevel user

!include LogicLib.nsh
!include MUI2.nsh

!define UNINSTALL "Software\Microsoft\Windows\CurrentVersion\Uninstall\Bathyscope"
!define CLASSES "Software\Classes"

Name "Bathyscope"
BrandingText "Bathyscope ${VERSION}"
OutFile "${OUT}"
InstallDir "$LOCALAPPDATA\Programs\Bathyscope"
InstallDirRegKey HKCU "${UNINSTALL}" InstallLocation
VIProductVersion ${NUMBERS}
VIAddVersionKey ProductName "Bathyscope"
VIAddVersionKey FileDescription "Bathyscope, installer"
VIAddVersionKey FileVersion "${VERSION}"
VIAddVersionKey ProductVersion "${VERSION}"
VIAddVersionKey LegalCopyright "MIT or Apache-2.0"

!define MUI_ICON "..\..\desktop\bathyscope.ico"
!define MUI_UNICON "..\..\desktop\bathyscope.ico"
!define MUI_FINISHPAGE_RUN "$INSTDIR\Bathyscope.exe"
!insertmacro MUI_PAGE_DIRECTORY
!insertmacro MUI_PAGE_INSTFILES
!insertmacro MUI_PAGE_FINISH
!insertmacro MUI_UNPAGE_CONFIRM
!insertmacro MUI_UNPAGE_INSTFILES
!insertmacro MUI_LANGUAGE English

; A type of files and what opens it.
!macro Type ID TITLE
  WriteRegStr HKCU "${CLASSES}\${ID}" "" "${TITLE}"
  WriteRegStr HKCU "${CLASSES}\${ID}\DefaultIcon" "" "$INSTDIR\Bathyscope.exe,0"
  WriteRegStr HKCU "${CLASSES}\${ID}\shell\open\command" "" '"$INSTDIR\Bathyscope.exe" "%1"'
!macroend

; Logs stay with the program that opens them now; Bathyscope is offered beside it.
!macro Offer ENDING
  WriteRegStr HKCU "${CLASSES}\.${ENDING}\OpenWithProgids" "Bathyscope.Log" ""
!macroend

!macro Withdraw ENDING
  DeleteRegValue HKCU "${CLASSES}\.${ENDING}\OpenWithProgids" "Bathyscope.Log"
  DeleteRegKey /ifempty HKCU "${CLASSES}\.${ENDING}\OpenWithProgids"
  DeleteRegKey /ifempty HKCU "${CLASSES}\.${ENDING}"
!macroend

; The endings of src/log/formats/table.rs that only logs have; tests/windows/run compares them.
!macro EachEnding DO
  !insertmacro ${DO} sl2
  !insertmacro ${DO} sl3
  !insertmacro ${DO} slg
  !insertmacro ${DO} rsd
  !insertmacro ${DO} xtf
  !insertmacro ${DO} jsf
  !insertmacro ${DO} svlog
  !insertmacro ${DO} sdf
  !insertmacro ${DO} nmea
!macroend

; Has the desktop look at the file types again: SHCNE_ASSOCCHANGED.
!macro Refresh
  System::Call "shell32::SHChangeNotify(i 0x08000000, i 0, p 0, p 0)"
!macroend

; The program's file can be written while it does not run.
!macro RefuseRunning
  ${If} ${FileExists} "$INSTDIR\bin\bathyscope.exe"
    ClearErrors
    FileOpen $0 "$INSTDIR\bin\bathyscope.exe" a
    ${If} ${Errors}
      MessageBox MB_OK|MB_ICONEXCLAMATION "Bathyscope is running. Close it, and start this again." /SD IDOK
      Abort
    ${EndIf}
    FileClose $0
  ${EndIf}
!macroend

Function .onInit
  !insertmacro RefuseRunning
FunctionEnd

Function un.onInit
  !insertmacro RefuseRunning
FunctionEnd

Section
  SetOutPath "$INSTDIR"
  File /r "${STAGE}\*"
  WriteUninstaller "$INSTDIR\uninstall.exe"
  SetOutPath "$DOCUMENTS"
  CreateDirectory "$SMPROGRAMS\Bathyscope"
  CreateShortcut "$SMPROGRAMS\Bathyscope\Bathyscope.lnk" "$INSTDIR\Bathyscope.exe"
  CreateShortcut "$SMPROGRAMS\Bathyscope\Bathyscope command line.lnk" "$SYSDIR\cmd.exe" '/k "set "PATH=$INSTDIR\bin;%PATH%""' "$INSTDIR\Bathyscope.exe" 0
  !insertmacro Type Bathyscope.Project "Bathyscope project"
  !insertmacro Type Bathyscope.Log "Sonar log"
  WriteRegStr HKCU "${CLASSES}\.bathyscope" "" Bathyscope.Project
  !insertmacro EachEnding Offer
  !insertmacro Refresh
  WriteRegStr HKCU "${UNINSTALL}" DisplayName "Bathyscope"
  WriteRegStr HKCU "${UNINSTALL}" DisplayVersion "${VERSION}"
  WriteRegStr HKCU "${UNINSTALL}" DisplayIcon "$INSTDIR\Bathyscope.exe"
  WriteRegStr HKCU "${UNINSTALL}" InstallLocation "$INSTDIR"
  WriteRegStr HKCU "${UNINSTALL}" UninstallString '"$INSTDIR\uninstall.exe"'
  WriteRegStr HKCU "${UNINSTALL}" QuietUninstallString '"$INSTDIR\uninstall.exe" /S'
  WriteRegDWORD HKCU "${UNINSTALL}" NoModify 1
  WriteRegDWORD HKCU "${UNINSTALL}" NoRepair 1
SectionEnd

Section Uninstall
  ; By name: the folder may hold files of the user's.
  Delete "$INSTDIR\bin\bathyscope.exe"
  RMDir "$INSTDIR\bin"
  Delete "$INSTDIR\Bathyscope.exe"
  Delete "$INSTDIR\CHANGELOG.md"
  Delete "$INSTDIR\LICENSE-APACHE"
  Delete "$INSTDIR\LICENSE-MIT"
  Delete "$INSTDIR\README.md"
  Delete "$INSTDIR\THIRD-PARTY"
  Delete "$INSTDIR\uninstall.exe"
  RMDir "$INSTDIR"
  Delete "$SMPROGRAMS\Bathyscope\Bathyscope.lnk"
  Delete "$SMPROGRAMS\Bathyscope\Bathyscope command line.lnk"
  RMDir "$SMPROGRAMS\Bathyscope"
  ; How the window was left.
  Delete "$APPDATA\bathyscope\data\app.ron"
  RMDir "$APPDATA\bathyscope\data"
  RMDir "$APPDATA\bathyscope"
  DeleteRegValue HKCU "${CLASSES}\.bathyscope" ""
  DeleteRegKey /ifempty HKCU "${CLASSES}\.bathyscope"
  !insertmacro EachEnding Withdraw
  DeleteRegKey HKCU "${CLASSES}\Bathyscope.Project"
  DeleteRegKey HKCU "${CLASSES}\Bathyscope.Log"
  DeleteRegKey HKCU "${UNINSTALL}"
  !insertmacro Refresh
SectionEnd
