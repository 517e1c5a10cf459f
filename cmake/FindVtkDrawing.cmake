# Finds the parts of VTK that draw, and X11 under them. VTK's own configuration is not used: it would
# look for all that VTK was built with, Qt and MPI among it. Defines VtkDrawing::VtkDrawing.
set(vtk_versions 9.3 9.2 9.1)
list(TRANSFORM vtk_versions PREPEND vtk- OUTPUT_VARIABLE vtk_folders)
find_path(VTK_DRAWING_INCLUDE_DIR vtkRenderWindow.h PATH_SUFFIXES ${vtk_folders})
find_library(X11_DRAWING_LIBRARY X11)
set(vtk_drawing_libraries)
foreach(part InteractionWidgets InteractionStyle RenderingAnnotation RenderingFreeType
             RenderingOpenGL2 RenderingUI RenderingCore FiltersCore CommonExecutionModel
             CommonTransforms CommonDataModel CommonMath CommonCore)
  set(vtk_names ${vtk_versions})
  list(TRANSFORM vtk_names PREPEND vtk${part}-)
  find_library(VTK_${part}_LIBRARY NAMES ${vtk_names})
  list(APPEND vtk_drawing_libraries VTK_${part}_LIBRARY)
endforeach()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(VtkDrawing
  REQUIRED_VARS VTK_DRAWING_INCLUDE_DIR X11_DRAWING_LIBRARY ${vtk_drawing_libraries})
if(VtkDrawing_FOUND AND NOT TARGET VtkDrawing::VtkDrawing)
  add_library(VtkDrawing::VtkDrawing INTERFACE IMPORTED GLOBAL)
  target_include_directories(VtkDrawing::VtkDrawing SYSTEM INTERFACE ${VTK_DRAWING_INCLUDE_DIR})
  foreach(library IN LISTS vtk_drawing_libraries)
    target_link_libraries(VtkDrawing::VtkDrawing INTERFACE ${${library}})
  endforeach()
  target_link_libraries(VtkDrawing::VtkDrawing INTERFACE ${X11_DRAWING_LIBRARY})
endif()
